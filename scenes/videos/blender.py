#!/usr/bin/env python3
"""Brings the frames of `cuticle simulate` into Blender, as curves that move, to be lit and rendered there:

  PATH=/usr/bin:$PATH blender -b --factory-startup -P scenes/videos/blender.py -- frames/%04d.hair 0:64 hair.blend [FPS]

hair.blend holds an object "hair" of a curve for each strand, in metres with z up. It follows an object "points", which hair.pc2 beside
the file moves, a point cache that Blender reads by itself (Mesh Cache), so that nothing of this script is needed to play it. (Debian's Blender has neither
USD nor Alembic. It takes Python from the first python3 in PATH, which must be the system's.)
"""
import os
import struct
import sys

import bpy
import numpy

METRES = 0.01  # in a centimetre


def read_hair(name):
    """The points of each strand and the width at the roots (cm), from a .hair file (cyHair)."""
    data = open(name, "rb").read()
    if data[:4] != b"HAIR":
        sys.exit(f"{name} is no .hair file")
    strands, points, arrays, segments = struct.unpack_from("<IIII", data, 4)
    width, at, counts = struct.unpack_from("<f", data, 20)[0], 128, [segments + 1] * strands
    if arrays & 1:
        counts = [n + 1 for n in struct.unpack_from(f"<{strands}H", data, at)]
        at += 2 * strands
    place = numpy.frombuffer(data, "<f4", 3 * points, at).reshape(-1, 3)
    at += 12 * points
    if arrays & 4:
        width = float(numpy.frombuffer(data, "<f4", points, at)[0])
    return counts, place, width


def to_blender(place):
    """y up, cm -> z up, m."""
    return numpy.stack([place[:, 0], -place[:, 2], place[:, 1]], -1).astype("<f4") * METRES


def add_curves(points, radius):
    """An object "hair" of the curves along the edges of another, of this radius (m)."""
    nodes = bpy.data.node_groups.new("strands", "GeometryNodeTree")
    nodes.outputs.new("NodeSocketGeometry", "Geometry")
    source, curves, width, end = (nodes.nodes.new(kind) for kind in ("GeometryNodeObjectInfo", "GeometryNodeMeshToCurve",
                                                                     "GeometryNodeSetCurveRadius", "NodeGroupOutput"))
    source.inputs["Object"].default_value = points
    width.inputs["Radius"].default_value = radius
    for one, other in ((source.outputs["Geometry"], curves), (curves.outputs[0], width), (width.outputs[0], end)):
        nodes.links.new(one, other.inputs[0])
    hair = bpy.data.objects.new("hair", bpy.data.hair_curves.new("hair"))
    hair.modifiers.new("strands", "NODES").node_group = nodes
    bpy.context.scene.collection.objects.link(hair)


def main():
    if "--" not in sys.argv or len(words := sys.argv[sys.argv.index("--") + 1:]) not in (3, 4):
        sys.exit(__doc__)
    pattern, frames, output = words[:3]
    first, last = (int(n) for n in frames.split(":"))
    if not output.endswith(".blend") or last < first:
        sys.exit("frames are FIRST:LAST, and the output's name ends in .blend")
    output = os.path.abspath(output)
    cache = output[:-len(".blend")] + ".pc2"
    counts, place, width = read_hair(pattern % first)
    with open(cache, "wb") as file:
        file.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(place), float(first), 1.0, last - first + 1))
        for frame in range(first, last + 1):
            now, points, _ = read_hair(pattern % frame)
            if now != counts:
                sys.exit(f"{pattern % frame} has other strands than {pattern % first}")
            file.write(to_blender(points).tobytes())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ends = numpy.cumsum(counts)
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata(to_blender(place).tolist(), [(k, k + 1) for n, end in zip(counts, ends) for k in range(int(end) - n, int(end) - 1)], [])
    thing = bpy.data.objects.new("points", mesh)
    bpy.context.scene.collection.objects.link(thing)
    moves = thing.modifiers.new("motion", "MESH_CACHE")
    moves.cache_format, moves.filepath, moves.frame_start = "PC2", "//" + os.path.basename(cache), first
    thing.hide_render = True
    add_curves(thing, width * METRES / 2)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = first, last, int(words[3]) if len(words) == 4 else 24
    scene.frame_set(first)
    bpy.ops.wm.save_as_mainfile(filepath=output)
    print(f"wrote {output} and {cache}: {len(counts)} strands, {last - first + 1} frames")


main()
