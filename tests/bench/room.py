#!/usr/bin/env python3
"""Writes a mixed scene to measure, a head of 50,000 strands in a room of 10^6 triangles; and says where a render's time goes.

  python3 tests/bench/room.py FOLDER [TRIANGLES]
  perf record -e cpu-clock -F 499 -o FOLDER/perf.data build/release/cuticle render FOLDER/room.pbrt --stats FOLDER/stats.json -o FOLDER/room.exr
  python3 tests/bench/room.py --shares FOLDER

FOLDER/room.pbrt is the scene, 256 x 256 and 16 samples per pixel; the PLY files beside it are four walls, a floor and a curtain, each a sixth
of the triangles, all uneven. The shares are of processor time in the last render_s seconds of the record, by the innermost function.
"""
import array
import collections
import json
import math
import pathlib
import re
import subprocess
import sys

SCENE = """# {triangles} triangles beside the head; written by tests/bench/room.py. Units: cm; y up.
Film "image" "integer xresolution" 256 "integer yresolution" 256 "string filename" "room.exr"
Sampler "sobol" "integer pixelsamples" 16
Integrator "path" "integer maxdepth" 30
Scale -1 1 1
LookAt 34 6 108   3 -3.5 0   0 1 0
Camera "perspective" "float fov" 34
WorldBegin
AttributeBegin
AreaLightSource "diffuse" "blackbody L" [6500 26]
Material ""
Translate -105 28 48
Rotate 90 0 1 0
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-42 -45 0  42 -45 0  42 45 0  -42 45 0]
AttributeEnd
LightSource "infinite" "rgb L" [0.3 0.25 0.2]
Material "matte" "rgb Kd" [0.13 0.24 0.25]
{walls}Material "substrate" "rgb Kd" [0.2 0.09 0.04] "float uroughness" 0.1 "float vroughness" 0.1
Shape "plymesh" "string filename" "floor.ply"
Material "disney" "rgb color" [0.3 0.03 0.045] "float roughness" 0.85 "float sheen" 1
Shape "plymesh" "string filename" "curtain.ply"
AttributeBegin
Translate 35 -22 16
Material "glass"
Shape "sphere" "float radius" 5
Translate -70 0 -12
Material "metal" "float roughness" 0.05
Shape "sphere" "float radius" 5
AttributeEnd
AttributeBegin
Rotate -14 0 1 0
Material "uber" "rgb Kd" [0.44 0.28 0.21] "rgb Ks" [0.04 0.04 0.04] "float roughness" 0.25
Shape "groomhead"
Material "hair" "float eumelanin" 0.2 "float pheomelanin" 0.75
Shape "groom" "string style" "wavy" "integer strands" 50000
AttributeEnd
WorldEnd
"""


def ripple(s, t):
    """Uneven plaster, in cm: waves of several lengths, none a multiple of another."""
    return 0.2 * sum(math.sin(f * s + g * t + p) / (1 + k) for k, (f, g, p) in enumerate(((31, 17, 0), (57, -83, 1), (151, 113, 2), (-271, 317, 3))))


def folds(s, t):
    return 5 * math.sin(2 * math.pi * (6.5 * s + 0.35 * math.sin(2.1 * math.pi * s))) * (0.5 + 0.5 * t) + 0.3 * ripple(s, t)


def write_mesh(path, cells, corner, along, up, height):
    """A grid of cells x cells squares from a corner along two edges, raised by height(s, t) along the cross product of the edges."""
    normal = [along[(i + 1) % 3] * up[(i + 2) % 3] - along[(i + 2) % 3] * up[(i + 1) % 3] for i in range(3)]
    length = math.hypot(*normal)
    points, faces = array.array("f"), bytearray()
    for j in range(cells + 1):
        for i in range(cells + 1):
            s, t = i / cells, j / cells
            h = height(s, t) / length
            points.extend(corner[k] + s * along[k] + t * up[k] + h * normal[k] for k in range(3))
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i
            b, c, d = a + 1, a + cells + 2, a + cells + 1
            for triangle in ((a, b, c), (a, c, d)):
                faces += b"\3" + array.array("i", triangle).tobytes()
    header = (f"ply\nformat binary_{sys.byteorder}_endian 1.0\nelement vertex {len(points) // 3}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {2 * cells * cells}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + points.tobytes() + faces)


# The first pattern that a sample's function or library fits names its part.
PARTS = (
    ("curves: traversal", r"curve_kernel::|CurveSet::"),
    ("triangles: second look at hits, in double", r"MeetPlane|MeshFilter"),
    ("triangles and quadrics: traversal", r"libembree|SolidSet::(Intersect|Occluded)|Quadric|Scene::(Part::)?(Intersect|Occluded)"),
    ("hair: scattering", r"cuticle::(avx\w*|sse\w*|scalar|generic)::|HairB|HairM|HairLanes|MakeCurveSurface"),
    ("surfaces: scattering", r"SurfaceLobes|BSDF|TrowbridgeReitz|Fr(Dielectric|Schlick|Conductor)|Material|ShadingFrame|Texture|Describe"),
    ("samples, lights, film", r"Sampler|Light|Film|Li$|SolidSet::|Sample|Distribution|Filter|OffsetRayOrigin"),
    ("the rest", r""),
)


def shares(folder):
    stats = json.loads((folder / "stats.json").read_text())
    text = subprocess.run(["perf", "script", "-i", folder / "perf.data", "-F", "time,ip,sym,dso"], capture_output=True, text=True, check=True).stdout
    samples = [(float(time), name) for time, name in re.findall(r"^ *([\d.]+): +[0-9a-f]+ +(.*)$", text, re.M)]
    if not samples:
        sys.exit("perf recorded no samples")
    begin = samples[-1][0] - stats["render_s"]
    names = [re.sub(r"\(/.*/", "(", name) for time, name in samples if time >= begin]
    counts = collections.Counter(next(part for part, pattern in PARTS if re.search(pattern, name)) for name in names)
    print(f"{stats['rays']} rays, {stats['shadow_rays']} shadow rays, {stats['curves']} curves, {stats['peak_rss_mb']:.0f} MB; "
          f"built in {stats['build_s']:.1f} s, rendered in {stats['render_s']:.1f} s on {stats['threads']} threads; {len(names)} samples")
    for part, _ in PARTS:
        print(f"{100 * counts[part] / len(names):5.1f} % {part}")


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--shares":
        return shares(pathlib.Path(sys.argv[2]))
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder, triangles = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) == 3 else 1_000_000
    folder.mkdir(parents=True, exist_ok=True)
    cells = math.ceil(math.sqrt(triangles / 12))
    walls = {"back": ((-120, -27, -60), (270, 0, 0), (0, 177, 0)), "left": ((-120, -27, 240), (0, 0, -300), (0, 177, 0)),
             "right": ((150, -27, -60), (0, 0, 300), (0, 177, 0)), "ceiling": ((-120, 150, -60), (270, 0, 0), (0, 0, 300))}
    for name, edges in walls.items():
        write_mesh(folder / f"{name}.ply", cells, *edges, ripple)
    write_mesh(folder / "floor.ply", cells, (-120, -27, 240), (270, 0, 0), (0, 0, -300), ripple)
    write_mesh(folder / "curtain.ply", cells, (-92, -27, -50), (62, 0, 0), (0, 117, 0), folds)
    text = SCENE.format(triangles=12 * cells * cells, walls="".join(f'Shape "plymesh" "string filename" "{name}.ply"\n' for name in walls))
    (folder / "room.pbrt").write_text(text)


main()
