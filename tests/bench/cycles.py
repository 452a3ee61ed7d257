#!/usr/bin/env python3
"""Renders the same strands with Cuticle and with Blender's Cycles (Debian's package blender), and compares error x CPU time.

  python3 tests/bench/cycles.py FOLDER [--program build/release/cuticle] [--scenes ball,sparse-ball,head-wavy,quickstart]
                                       [--samples 4,16,64] [--size 256] [--seeds 2]

Both get the same points, widths, mesh, camera, lights and absorption, a box filter of one pixel, two threads and as many
bounces. FOLDER keeps the scenes, the pictures of both programs (EXR, PFM) and results.json;
references that it holds are not rendered again. The error of a picture is the
mean of squared differences, relative to the squared truth plus .01, of pixels and of means over blocks of 8 x 8 pixels,
against that program's own converged picture: the product of the differences to two independent references, which their noise
does not change in the mean. Cuticle's time is the processor time of its whole process; Cycles' is that of its render
alone (its own acceleration structure included), without the start of Blender and the making of its scene: in its favour.
Debian's Blender has no denoiser, so Cycles' pictures are as sampled; Cuticle stands beside it both ways.
"""
import argparse
import json
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

try:
    import bpy  # only inside Blender
    import numpy
except ImportError:
    bpy = None

BALL = """LookAt 0 0 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 35
Integrator "path" "integer maxdepth" 30
WorldBegin
LightSource "infinite" "rgb L" [0.15 0.17 0.2]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [40 38 35]
Translate 3 4 -3
Shape "sphere" "float radius" 0.5
AttributeEnd
Material "hair" "float eumelanin" 0.3
Shape "hairfile" "string filename" "{hair}"
WorldEnd
"""
BALLS = {"ball": 50000, "sparse-ball": 2000}
BOUNCES = 64
REFERENCE_SAMPLES = 256


# ---- The scene: the statements that these scenes use, nothing else. ----

def identity():
    return [[float(r == c) for c in range(4)] for r in range(4)]


def times(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def rotation(degrees, axis):
    n = math.sqrt(sum(a * a for a in axis))
    x, y, z = (a / n for a in axis)
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    k = 1 - c
    return [[x * x * k + c, x * y * k - z * s, x * z * k + y * s, 0], [x * y * k + z * s, y * y * k + c, y * z * k - x * s, 0],
            [x * z * k - y * s, y * z * k + x * s, z * z * k + c, 0], [0, 0, 0, 1]]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    n = math.sqrt(sum(x * x for x in a))
    return [x / n for x in a]


def inverse_rigid(m):
    """Inverts a matrix whose first three columns are at right angles and equally long."""
    scale = sum(m[r][0] ** 2 for r in range(3))
    out = [[m[c][r] / scale for c in range(3)] for r in range(3)]
    return [out[r] + [-sum(out[r][k] * m[k][3] for k in range(3))] for r in range(3)] + [[0, 0, 0, 1]]


def parse(text):
    """Yields each statement as (word, arguments); parameters become a dictionary of lists at the end of the arguments."""
    tokens = re.findall(r'#[^\n]*|"[^"]*"|\[|\]|[^\s\[\]"#]+', text)
    tokens = [t for t in tokens if not t.startswith("#")]
    i = 0
    while i < len(tokens):
        word, args, params = tokens[i], [], {}
        i += 1
        while i < len(tokens) and not re.match(r"[A-Z]", tokens[i]):
            token = tokens[i]
            i += 1
            if token.startswith('"') and " " in token:
                values = [tokens[i]]
                i += 1
                if values == ["["]:
                    end = tokens.index("]", i)
                    values, i = tokens[i:end], end + 1
                params[token.strip('"').split()[1]] = [v.strip('"') if v.startswith('"') else float(v) if v not in ("true", "false") else v for v in values]
            elif token not in "[]":
                args.append(token.strip('"') if token.startswith('"') else float(token))
        yield word, args, params


def read_scene(text, folder):
    """Reads a scene into a dictionary: camera, fov, hair, meshes, lights; all in the world's coordinates."""
    scene = {"meshes": [], "lights": []}
    ctm, stack, material, light = identity(), [], None, None
    for word, args, params in parse(text):
        if word == "Scale":
            ctm = times(ctm, [[args[0], 0, 0, 0], [0, args[1], 0, 0], [0, 0, args[2], 0], [0, 0, 0, 1]])
        elif word == "Translate":
            ctm = times(ctm, [[1, 0, 0, args[0]], [0, 1, 0, args[1]], [0, 0, 1, args[2]], [0, 0, 0, 1]])
        elif word == "Rotate":
            ctm = times(ctm, rotation(args[0], args[1:]))
        elif word == "LookAt":
            forward = unit([args[3 + k] - args[k] for k in range(3)])
            right = unit(cross(unit(args[6:]), forward))
            up = cross(forward, right)
            ctm = times(ctm, inverse_rigid([[right[k], up[k], forward[k], args[k]] for k in range(3)] + [[0, 0, 0, 1]]))
        elif word == "Camera":
            scene["camera"], scene["fov"] = inverse_rigid(ctm), params["fov"][0]
        elif word == "WorldBegin":
            ctm = identity()
        elif word == "AttributeBegin":
            stack.append((ctm, material, light))
        elif word == "AttributeEnd":
            ctm, material, light = stack.pop()
        elif word == "Material":
            material = (args[0], params)
        elif word == "AreaLightSource":
            light = params["L"]
        elif word == "LightSource":
            entry = {"kind": args[0], "L": params.get("L", [1, 1, 1]), "to_world": ctm}
            if "mapname" in params:
                entry["map"] = str((folder / params["mapname"][0]).resolve())
            if args[0] == "distant":
                entry["direction"] = unit([params["to"][k] - params["from"][k] for k in range(3)])
            scene["lights"].append(entry)
        elif word == "Shape" and args[0] == "sphere":
            scene["lights"].append({"kind": "sphere", "L": light, "radius": params["radius"][0], "center": [ctm[r][3] for r in range(3)]})
        elif word == "Shape" and args[0] == "trianglemesh":
            p = params["P"]
            points = [[sum(ctm[r][k] * (p[3 * i + k] if k < 3 else 1) for k in range(4)) for r in range(3)] for i in range(len(p) // 3)]
            scene["meshes"].append({"points": points, "indices": [int(i) for i in params["indices"]], "L": light})
        elif word == "Shape" and args[0] == "plymesh":
            scene["meshes"].append({"ply": params["filename"][0], "material": material[1]})
        elif word == "Shape" and args[0] == "hairfile":
            scene["hair"] = params["filename"][0]
            melanin = [material[1].get(k, [0])[0] for k in ("eumelanin", "pheomelanin")]
            scene["sigma_a"] = [melanin[0] * e + melanin[1] * p for e, p in zip((0.419, 0.697, 1.37), (0.187, 0.4, 1.05))]
            scene["hair_material"] = {k: material[1].get(k, [d])[0] for k, d in (("beta_m", 0.3), ("beta_n", 0.3), ("alpha", 2.0), ("eta", 1.55))}
    return scene


def write_scene(program, name, folder, size):
    """Writes FOLDER/name.pbrt, name.hair and, for a head, name.ply; returns the scene's text and the picture's size."""
    hair = folder / f"{name}.hair"
    if name in BALLS:
        subprocess.run([program, "groom", "ball", "--strands", str(BALLS[name]), "--segments", "8", "-o", hair, "-q"], check=True)
        width = height = size
        body = BALL.format(hair=hair)
    else:
        source = pathlib.Path(__file__).resolve().parents[2] / "scenes" / f"{name}.pbrt"
        body = source.read_text()
        w, h = (int(re.search(rf'"integer {a}resolution" (\d+)', body)[1]) for a in "xy")
        width, height = size * w // max(w, h), size * h // max(w, h)
        groom = next(p for word, args, p in parse(body) if word == "Shape" and args[0] == "groom")
        options = [f"--{k.replace('_', '-')}={v[0] if isinstance(v[0], str) or v[0] % 1 else int(v[0])}" for k, v in groom.items()]
        mesh = folder / f"{name}.ply"
        subprocess.run([program, "groom", "head", *options, "--mesh", mesh, "-o", hair, "-q"], check=True)
        body = re.sub(r'(?m)^\s*"bool denoise".*$|^(Film|Sampler|PixelFilter).*$', "", body)
        body = re.sub(r'(?m)Shape "groom" .*(\n\s+"[^\n]*)*', f'Shape "hairfile" "string filename" "{hair}"', body)
        body = re.sub(r'(?m)Shape "groomhead".*', f'Shape "plymesh" "string filename" "{mesh}"', body)
        body = re.sub(r'"textures/', f'"{source.parent}/textures/', body)
        body = re.sub(r'"integer maxdepth" \d+', f'"integer maxdepth" {BOUNCES}', body)
    text = (f'Film "image" "integer xresolution" {width} "integer yresolution" {height} "string filename" "{name}.exr"\n'
            'Sampler "sobol"\nPixelFilter "box"\n' + body)
    path = folder / f"{name}.pbrt"
    path.write_text(text)
    return path, text, (width, height)


# ---- Inside Blender. ----

def read_hair(path):
    """Reads a .hair file: the points, the widths at them, and the points of each strand."""
    data = open(path, "rb").read()
    strands, points, arrays, segments = numpy.frombuffer(data, "<u4", 4, 4)
    width = numpy.frombuffer(data, "<f4", 1, 20)[0]
    at = 128
    counts = numpy.full(strands, segments, int)
    if arrays & 1:
        counts = numpy.frombuffer(data, "<u2", strands, at).astype(int)
        at += 2 * int(strands)
    p = numpy.frombuffer(data, "<f4", 3 * points, at).reshape(-1, 3)
    at += 12 * int(points)
    widths = numpy.frombuffer(data, "<f4", points, at) if arrays & 4 else numpy.full(points, width, numpy.float32)
    return p, widths, counts + 1


def add_hair(scene, mirror):
    """Makes curves by geometry nodes: the points as a mesh of edges, turned into curves with the radii of an attribute."""
    points, widths, counts = read_hair(scene["hair"])
    mesh = bpy.data.meshes.new("strands")
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", (points * mirror).ravel())
    first = numpy.ones(len(points), bool)
    first[numpy.concatenate([[0], numpy.cumsum(counts)[:-1]])] = False
    ends = numpy.nonzero(first)[0]
    mesh.edges.add(len(ends))
    mesh.edges.foreach_set("vertices", numpy.stack([ends - 1, ends], 1).astype(numpy.int32).ravel())
    mesh.attributes.new("thick", "FLOAT", "POINT").data.foreach_set("value", widths / 2)
    source = bpy.data.objects.new("strands", mesh)
    nodes = bpy.data.node_groups.new("strands", "GeometryNodeTree")
    nodes.outputs.new("NodeSocketGeometry", "Geometry")
    new = nodes.nodes.new
    info, curve, radius, named, out = (new(k) for k in ("GeometryNodeObjectInfo", "GeometryNodeMeshToCurve", "GeometryNodeSetCurveRadius",
                                                        "GeometryNodeInputNamedAttribute", "NodeGroupOutput"))
    info.inputs["Object"].default_value = source
    named.data_type = "FLOAT"
    named.inputs["Name"].default_value = "thick"
    link = nodes.links.new
    link(info.outputs["Geometry"], curve.inputs["Mesh"])
    link(curve.outputs["Curve"], radius.inputs["Curve"])
    link(next(o for o in named.outputs if o.enabled), radius.inputs["Radius"])
    link(radius.outputs["Curve"], out.inputs[0])
    hair = bpy.data.objects.new("hair", bpy.data.hair_curves.new("hair"))
    hair.modifiers.new("strands", "NODES").node_group = nodes
    material = bpy.data.materials.new("hair")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, end = tree.nodes.new("ShaderNodeBsdfHairPrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.parametrization = "ABSORPTION"
    m = scene["hair_material"]
    for key, value in (("Absorption Coefficient", scene["sigma_a"]), ("Roughness", m["beta_m"]), ("Radial Roughness", m["beta_n"]), ("Coat", 0),
                       ("IOR", m["eta"]), ("Offset", math.radians(m["alpha"])), ("Random Roughness", 0), ("Random Color", 0)):
        shader.inputs[key].default_value = value
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    hair.data.materials.append(material)
    # Mesh to Curve gives its curves no material of its own.
    slot = new("GeometryNodeSetMaterial")
    slot.inputs["Material"].default_value = material
    link(radius.outputs["Curve"], slot.inputs["Geometry"])
    link(slot.outputs["Geometry"], out.inputs[0])
    bpy.context.scene.collection.objects.link(hair)
    return len(points)


def shader_material(kind, **values):
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, end = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for key, value in values.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    return material


def add_mesh(entry, mirror):
    if "ply" in entry:
        bpy.ops.import_mesh.ply(filepath=entry["ply"])
        thing = bpy.context.object
        co = numpy.empty(3 * len(thing.data.vertices), numpy.float32)
        thing.data.vertices.foreach_get("co", co)
        thing.data.vertices.foreach_set("co", (co.reshape(-1, 3) * mirror).ravel())
        thing.data.polygons.foreach_set("use_smooth", [True] * len(thing.data.polygons))
        kd = entry["material"].get("Kd", [0.25] * 3)
        thing.data.materials.clear()
        thing.data.materials.append(shader_material("ShaderNodeBsdfPrincipled", Base_Color=(*kd, 1), Roughness=0.88, Specular=0.5))
        return
    mesh = bpy.data.meshes.new("emitter")
    mesh.from_pydata([[p[k] * mirror[k] for k in range(3)] for p in entry["points"]], [],
                     [entry["indices"][i:i + 3] for i in range(0, len(entry["indices"]), 3)])
    mesh.materials.append(shader_material("ShaderNodeEmission", Color=(*entry["L"], 1), Strength=1))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("emitter", mesh))


def add_sky(entry, mirror):
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1
    if "map" not in entry:
        background.inputs["Color"].default_value = (*entry["L"], 1)
        return
    source = bpy.data.images.load(entry["map"])
    w, h = source.size
    pixels = numpy.array(source.pixels[:], numpy.float32).reshape(h, w, -1)[::-1, :, :3]
    # Cycles' direction of each pixel of its map (rows from below): u = 1/2 - atan2(y, x) / 2 pi, v = asin(z) / pi + 1/2.
    v, u = numpy.meshgrid((numpy.arange(h) + 0.5) / h, (numpy.arange(w) + 0.5) / w, indexing="ij")
    z, azimuth = numpy.sin((v - 0.5) * math.pi), (u - 0.5) * 2 * math.pi
    flat = numpy.sqrt(numpy.maximum(0, 1 - z * z))
    d = numpy.stack([flat * numpy.cos(azimuth), -flat * numpy.sin(azimuth), z], -1) * mirror
    light = d @ numpy.array(entry["to_world"])[:3, :3]
    light /= numpy.linalg.norm(light, axis=-1, keepdims=True)
    theta, phi = numpy.arccos(numpy.clip(light[..., 2], -1, 1)), numpy.arctan2(light[..., 1], light[..., 0]) % (2 * math.pi)
    x, y = phi / (2 * math.pi) * w - 0.5, theta / math.pi * h - 0.5
    x0, y0 = numpy.floor(x).astype(int), numpy.floor(y).astype(int)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    at = lambda a, b: pixels[numpy.clip(b, 0, h - 1), a % w]
    sky = (at(x0, y0) * (1 - fx) + at(x0 + 1, y0) * fx) * (1 - fy) + (at(x0, y0 + 1) * (1 - fx) + at(x0 + 1, y0 + 1) * fx) * fy
    image = bpy.data.images.new("sky", w, h, float_buffer=True)
    image.colorspace_settings.name = "Linear"
    image.pixels.foreach_set(numpy.concatenate([sky * entry["L"], numpy.ones((h, w, 1))], -1).astype(numpy.float32).ravel())
    image.pack()
    node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    world.node_tree.links.new(node.outputs["Color"], background.inputs["Color"])


def make_blender_scene(scene, size):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    camera = numpy.array(scene["camera"])
    right, up, forward = (camera[:3, k] / numpy.linalg.norm(camera[:3, k]) for k in range(3))
    # pbrt's camera looks along +z of a left-handed frame; where the scene's world is left-handed too, all of it is mirrored.
    mirror = numpy.array([-1.0, 1, 1] if numpy.dot(numpy.cross(right, up), forward) > 0 else [1.0, 1, 1])
    import mathutils
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit = "VERTICAL" if size[1] < size[0] else "HORIZONTAL"
    setattr(lens, "angle_y" if size[1] < size[0] else "angle_x", math.radians(scene["fov"]))
    lens.clip_start, lens.clip_end = 1e-3, 1e5
    eye = bpy.data.objects.new("camera", lens)
    frame = numpy.eye(4)
    for k, axis in enumerate((right, up, -forward, camera[:3, 3])):
        frame[:3, k] = axis * mirror
    eye.matrix_world = mathutils.Matrix(frame.tolist())
    bpy.context.scene.collection.objects.link(eye)
    bpy.context.scene.camera = eye
    for entry in scene["lights"]:
        if entry["kind"] == "infinite":
            add_sky(entry, mirror)
            continue
        lamp = bpy.data.lights.new("lamp", "SUN" if entry["kind"] == "distant" else "POINT")
        thing = bpy.data.objects.new("lamp", lamp)
        lamp.color, lamp.energy = entry["L"], 1
        lamp.cycles.max_bounces = BOUNCES
        if entry["kind"] == "distant":
            lamp.angle = 0
            thing.matrix_world = mathutils.Vector((numpy.array(entry["direction"]) * -mirror).tolist()).to_track_quat("Z", "Y").to_matrix().to_4x4()
        else:
            # A sphere of radiance L and radius r emits 4 pi^2 r^2 L; the lamp's strength is its whole power.
            lamp.shadow_soft_size, lamp.energy = entry["radius"], 4 * math.pi ** 2 * entry["radius"] ** 2
            thing.location = (numpy.array(entry["center"]) * mirror).tolist()
        bpy.context.scene.collection.objects.link(thing)
    for entry in scene["meshes"]:
        add_mesh(entry, mirror)
    add_hair(scene, mirror)
    s = bpy.context.scene
    s.render.engine = "CYCLES"
    s.render.resolution_x, s.render.resolution_y, s.render.resolution_percentage = *size, 100
    s.render.threads_mode, s.render.threads = "FIXED", 2
    s.render.image_settings.file_format, s.render.image_settings.color_depth = "OPEN_EXR", "32"
    s.render.image_settings.color_mode = "RGB"
    s.view_settings.view_transform = "Raw"
    s.render.film_transparent = False
    s.cycles.device, s.cycles.use_adaptive_sampling, s.cycles.use_denoising = "CPU", False, False
    s.cycles.pixel_filter_type = "BOX"
    s.cycles.filter_width = 1
    for k in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(s.cycles, k, BOUNCES)
    s.cycles.sample_clamp_direct = s.cycles.sample_clamp_indirect = s.cycles.blur_glossy = 0
    s.cycles_curves.shape = "THICK"


def picture(path):
    """Reads a .pfm of little-endian floats as this program writes it."""
    head, size, _, data = open(path, "rb").read().split(b"\n", 3)
    w, h = map(int, size.split())
    return numpy.frombuffer(data, "<f4").astype(float).reshape(h, w, 3)


def blocks(p):
    h, w = p.shape[0] // 8 * 8, p.shape[1] // 8 * 8
    return p[:h, :w].reshape(h // 8, 8, w // 8, 8, 3).mean((1, 3))


def inside_blender(job):
    job = json.loads(pathlib.Path(job).read_text())
    if job["role"] == "render":
        make_blender_scene(job["scene"], job["size"])
        s = bpy.context.scene
        done = []
        for shot in job["shots"]:
            s.cycles.samples, s.cycles.seed, s.render.filepath = shot["samples"], shot["seed"], shot["out"]
            start = time.process_time()
            bpy.ops.render.render(write_still=True)
            done.append({**shot, "cpu": time.process_time() - start})
        pathlib.Path(job["out"]).write_text(json.dumps(done))
        return
    rows = []
    for row in job["rows"]:
        a, b = (picture(p) for p in row["references"])
        r = (a + b) / 2
        out = {"mean": r.mean(), "own": numpy.mean((a - b) ** 2 / 2 / (r ** 2 + 0.01)) / 2}
        for key, f in (("pixels", lambda p: p), ("blocks", blocks)):
            errors = [numpy.mean((f(p) - f(a)) * (f(p) - f(b)) / (f(r) ** 2 + 0.01)) for p in map(picture, row["pictures"])]
            out[key] = float(numpy.mean(errors))
        out["bias_of_mean"] = float(numpy.mean([picture(p).mean() for p in row["pictures"]]) / r.mean() - 1)
        rows.append({**row, **out})
    pathlib.Path(job["out"]).write_text(json.dumps(rows))


# ---- Outside Blender. ----

def blender(job, folder):
    where = folder / "job.json"
    out = folder / "job.out.json"
    out.unlink(missing_ok=True)
    where.write_text(json.dumps({**job, "out": str(out)}))
    # Blender takes the modules of the first python3 in PATH, which has to be the system's own: it has numpy.
    run = subprocess.run(["blender", "-b", "--factory-startup", "-P", __file__, "--", str(where)], capture_output=True, text=True,
                         env={**os.environ, "PATH": "/usr/bin:" + os.environ["PATH"]})
    if not out.exists():
        sys.exit(f"error: Blender ended without a result:\n{(run.stdout + run.stderr)[-3000:]}")
    return json.loads(out.read_text())


def child_cpu():
    use = resource.getrusage(resource.RUSAGE_CHILDREN)
    return use.ru_utime + use.ru_stime


def measure(args, name):
    scene_path, text, size = write_scene(args.program, name, args.folder, args.size)
    scene = read_scene(text, args.folder)
    shots = {"Cycles": [], "Cuticle": [], "Cuticle, denoised": []}
    plan = [(n, seed) for n in args.samples for seed in range(1, args.seeds + 1)] + [(REFERENCE_SAMPLES, 1001), (REFERENCE_SAMPLES, 1002)]
    path = lambda way, n, seed: str(args.folder / f"{name}-{way.replace(', ', '-').lower()}-{n}-{seed}.exr")
    for way in ("Cuticle", "Cuticle, denoised"):
        for n, seed in plan:
            if n == REFERENCE_SAMPLES and (way != "Cuticle" or pathlib.Path(path(way, n, seed)).exists()):
                continue
            start = child_cpu()
            subprocess.run([args.program, "render", scene_path, "-o", path(way, n, seed), "--spp", str(n), "--seed", str(seed), "--threads", "2", "-q",
                            "--denoise" if "denoised" in way else "--no-denoise"], check=True)
            shots[way].append({"samples": n, "seed": seed, "cpu": child_cpu() - start, "out": path(way, n, seed)})
    job = [{"samples": n, "seed": seed, "out": path("Cycles", n, seed)} for n, seed in plan
           if n < REFERENCE_SAMPLES or not pathlib.Path(path("Cycles", n, seed)).exists()]
    shots["Cycles"] = blender({"role": "render", "scene": scene, "size": size, "shots": job}, args.folder)
    rows = []
    for way, done in shots.items():
        references = [path("Cycles" if way == "Cycles" else "Cuticle", REFERENCE_SAMPLES, s).replace(".exr", ".pfm") for s in (1001, 1002)]
        for n in args.samples:
            mine = [s for s in done if s["samples"] == n]
            rows.append({"scene": name, "way": way, "samples": n, "cpu": sum(s["cpu"] for s in mine) / len(mine),
                         "pictures": [s["out"].replace(".exr", ".pfm") for s in mine], "references": references})
    for out in args.folder.glob(f"{name}-*.exr"):
        subprocess.run([args.program, "convert", out, out.with_suffix(".pfm")], check=True, stdout=subprocess.DEVNULL)
    rows = blender({"role": "measure", "rows": rows}, args.folder)
    for row in rows:
        peer = next(r for r in rows if r["way"] == "Cycles" and r["samples"] == row["samples"])
        ratio = {k: row[k] * row["cpu"] / (peer[k] * peer["cpu"]) for k in ("pixels", "blocks")}
        row["ratio"] = ratio
        print(f"{name:12} {row['way']:18} {row['samples']:4} samples  {row['cpu']:7.2f} CPU s  relMSE {row['pixels']:.5f}  blocks {row['blocks']:.6f}"
              f"  error x CPU / Cycles': {ratio['pixels']:.3f}  blocks {ratio['blocks']:.3f}   mean {row['mean']:.5f}", flush=True)
    return rows


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--program", default="build/release/cuticle", type=lambda s: str(pathlib.Path(s).resolve()))
    p.add_argument("--scenes", default="ball,sparse-ball,head-wavy,quickstart", type=lambda s: s.split(","))
    p.add_argument("--samples", default="4,16,64", type=lambda s: [int(n) for n in s.split(",")])
    p.add_argument("--size", default=256, type=int, help="pixels of the longer side")
    p.add_argument("--seeds", default=2, type=int, help="pictures a setting, whose errors are averaged")
    args = p.parse_args()
    if not shutil.which("blender"):
        sys.exit("error: blender is not installed; apt-get install blender")
    args.folder = args.folder.resolve()
    args.folder.mkdir(parents=True, exist_ok=True)
    rows = [row for name in args.scenes for row in measure(args, name)]
    (args.folder / "results.json").write_text(json.dumps(rows, indent=1))


if bpy and "--" in sys.argv:
    inside_blender(sys.argv[sys.argv.index("--") + 1])
elif __name__ == "__main__":
    main()
