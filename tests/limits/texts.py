"""Small text files that ask for much work: kind -> name -> text. They are read as what `kind` says."""

HUGE = ["1000000000", "2147483647", "4294967296", "1e308", "1e999", "-1", "0x7fffffff", "9" * 400,
        ".nan", ".inf"]


def nested(opening, closing, depth=300):
    return opening * depth + closing * depth


def alias_bomb(levels=24, width=9):
    """Each list is `width` times the one before it: 9^24 values, if they were copied."""
    text = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n"
    for i in range(1, levels):
        text += f"a{i}: &a{i} [" + ", ".join([f"*a{i - 1}"] * width) + "]\n"
    return text


def any_yaml():
    """What no reader of YAML may work on for long, whatever it expects."""
    last = "a23"
    return {
        "aliases": alias_bomb(),
        "aliases-used": alias_bomb(20, 6) + "".join(
            f"{key}: *a19\n" for key in ("boards", "target", "tags", "points", "frames", "views",
                                         "cam0", "value0", "camera_matrix", "path", "camera")),
        "self": "a: &a [*a]\n", "merge": "a: &a {b: 1}\nc: {<<: [*a, *a]}\n", "last": f"b: *{last}\n",
        "nested-lists": nested("[", "]"), "nested-maps": nested("{a: ", "}"),
        "nested-open": "[" * 1000, "nested-dashes": "- " * 500, "nested-keys": "? " * 500,
        "colons": ": " * 500, "anchors": "".join(f"a{i}: &x{i} 1\n" for i in range(80)),
        "tabs": "\t" * 1000, "quote": '"' + "x" * 1000, "block": "a: |\n" + " " * 1000,
        "long-key": "k" * 1020 + ": 1\n", "documents": "---\na: 1\n" * 100, "bom": "\ufeff" * 300,
        "tags": "a: " + "!!a " * 250, "percent": "%YAML 9.9\n" * 90, "commas": "[" + "," * 1000 + "]",
        "nul": "a: b\0c\n", "escape": 'a: "' + "\\x41" * 240 + '"\n', "newlines": "\n" * 1000,
    }


GRID = "target_type: aprilgrid\ntagCols: {c}\ntagRows: {r}\ntagSize: 0.01\ntagSpacing: 0.3\n"


def targets():
    files = {}
    for i, n in enumerate(HUGE):
        files |= {
            f"grid-{i}": GRID.format(c=n, r=n), f"rows-{i}": GRID.format(c=1, r=n),
            f"checker-{i}": f"{{target_type: checkerboard, targetCols: {n}, targetRows: {n}, "
                            "rowSpacingMeters: 1, colSpacingMeters: 1}",
            f"charuco-{i}": f"{{target_type: charuco, squareCols: {n}, squareRows: {n}, "
                            "squareSize: 2, markerSize: 1, dictionary: DICT_4X4_50}",
            f"id-{i}": f"{{target_type: tags, tags: [{{id: {n}, size: 1}}]}}",
            f"first-{i}": GRID.format(c=9, r=9) + f"first_id: {n}\n",
            f"size-{i}": GRID.format(c=9, r=9).replace("0.01", n),
            f"spacing-{i}": GRID.format(c=9, r=9).replace("0.3", n),
            f"bits-{i}": GRID.format(c=9, r=9) + f"border_bits: {n}\n",
            f"flatness-{i}": GRID.format(c=9, r=9) + f"flatness: {n}\nprint: {n}\n"}
    most = GRID.format(c=400, r=250)
    return files | {
        "most-tags": most, "most-in-a-row": GRID.format(c=100000, r=1),
        "most-52h13": GRID.format(c=400, r=120) + "family: tagStandard52h13\nborder_bits: 1\n",
        "most-corners": "{target_type: checkerboard, targetCols: 400, targetRows: 250, "
                        "rowSpacingMeters: 0.03, colSpacingMeters: 0.03}",
        "most-squares": "{target_type: charuco, squareCols: 400, squareRows: 250, squareSize: 0.03, "
                        "markerSize: 0.02, dictionary: DICT_5X5_1000}",
        "family": most + "family: " + "x" * 900,
        "points": "target_type: points\npoints:\n- &p [0, 1, 2, 3]\n" + "- *p\n" * 150,
        "tags": "target_type: tags\ntags:\n- &t {id: 1, size: 1, pose: {}}\n" + "- *t\n" * 150,
        "field": '{"field": {"length": 1e308, "width": 1}, "tags": [{"ID": 1e9}]}'}


SCENE = ("camera: {{image_size: [{w}, {h}], model: f, f: {f}}}\nboards:\n- target: &t {{target_type: "
         "aprilgrid, tagCols: 9, tagRows: 6, tagSize: 0.06, tagSpacing: 0.3}}\npath: {{type: ring, "
         "radius_m: 1}}\nviews: {v}\n")


def scene(w="64", h="48", f="50", v="1", more=""):
    return SCENE.format(w=w, h=h, f=f, v=v) + more


def scenes():
    big = scene().replace("tagCols: 9, tagRows: 6", "tagCols: 400, tagRows: 250")
    boards = "".join(f"- {{target: *t, first_id: {i * 100000}}}\n" for i in range(1, 24))
    centred = scene().replace("path:", "  world_from_board: {translation_m: [-0.35, -0.23, 0]}\npath:")
    corner = "[&p [0,0,0],[1,0,0],[0,1,0]" + ",*p" * 150 + "]"
    files = {
        "many-big-boards": big.replace("path:", boards + "path:"),
        "boards": scene().replace("path:", "- &b {target: *t}\n" + "- *b\n" * 150 + "path:"),
        "polygon": scene(more=f"occluders:\n- {{corners: {corner}}}\n"),
        "occluders": scene(more="occluders:\n- &o {corners: [[0,0,0],[1,0,0],[0,1,0]]}\n"
                           + "- *o\n" * 130),
        "cuboids": scene(more="cuboids:\n- &c {size_m: [1, 1, 1]}\n" + "- *c\n" * 150),
        "frames": scene(more="frames: [" + ",".join(f"{{name: f{i}, parent: f{i - 1}}}" if i else
                                                      "{name: f0}" for i in range(28)) + "]\n"),
        "frame-loop": scene(more="frames: [{name: a, parent: b}, {name: b, parent: a}]\n"),
        "steps": scene(more="frames: [{name: a}]\nmotion: [{frame: a, steps: [&s {rotate_z_deg: "
                            "&l [0" + ",9" * 99 + "]}" + ",*s" * 98 + "]}]\n"),
        "long-lens": centred.replace("f: 50", "f: 1e15"),
        "bent-lens": centred.replace("model: f, f: 50", "model: opencv5, f: 50, distortion: [1e6]"),
        "vignetting": scene(more="sensor: {vignetting: [" + "1," * 300 + "1]}\n"),
    }
    for i, n in enumerate(HUGE):
        files |= {f"size-{i}": scene(w=n, h=n), f"views-{i}": scene(v=n), f"focal-{i}": scene(f=n),
                  f"blur-{i}": scene(more=f"sensor: {{blur_px: {n}}}\n"),
                  f"noise-{i}": scene(more=f"sensor: {{noise_levels: {n}, bits: 16}}\n"),
                  f"margin-{i}": scene(more=f"paper_margin_m: {n}\n"),
                  f"binned-{i}": scene().replace("f: 50", f"f: 50, binned: [{n}, {n}]"),
                  f"resized-{i}": scene().replace("f: 50", f"f: 50, resized: [{n}, {n}]"),
                  f"sector-{i}": scene().replace("f: 50", f"f: 50, sector: {{columns: {n}, rows: {n},"
                                                          f" column: 0, row: 0}}"),
                  f"focus-{i}": scene(more=f"sensor: {{focus: {{distance_m: 1, f_number: 1, "
                                           f"focal_mm: {n}}}}}\n"),
                  f"radius-{i}": scene().replace("radius_m: 1", f"radius_m: {n}")}
    return files | {"size-100000": scene(w="100000", h="100000"), "size-20000": scene(w="20000",
                                                                                    h="20000")}


def cameras():
    matrix = "camera_matrix: {{rows: {r}, cols: {c}, data: [900,0,640,0,900,400,0,0,1]}}\n"
    size = "image_width: {w}\nimage_height: {h}\n"
    ok = matrix.format(r=3, c=3)
    colmap = "1 PINHOLE {w} {h} 900 900 640 400\n"
    nerf = '{{"w": {n}, "h": {n}, "fl_x": 900, "frames": [{f}]}}'
    frame = '{"file_path": "a", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}'
    files = {
        "largest.yaml": size.format(w=100000, h=100000) + ok,
        "colmap-lines.txt": colmap.format(w=1280, h=800) * 25,
        "colmap-words.txt": "1 PINHOLE " + "9 " * 480, "colmap-cr.txt": "1 A 2 3\r" * 120,
        "mrcal-nested.cameramodel": "{'lensmodel': " + "(" * 900,
        "mrcal.cameramodel": "{'lensmodel': 'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=99999_Ny="
                             "99999_fov_x_deg=200', 'intrinsics': [" + "1," * 300 + "1]}",
        "xml-nested.xml": "<?xml version='1.0'?><opencv_storage>" + "<a>" * 250,
        "xml-entities.xml": "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'>"
                            + "".join(f"<!ENTITY a{i} '&a{i - 1};&a{i - 1};'>" for i in range(1, 25))
                            + "]><opencv_storage>&a24;</opencv_storage>",
        "xml-attributes.xml": "<opencv_storage " + "a='b' " * 150 + ">",
        "json-nested.json": '{"a":' * 160, "json-lists.json": "[" * 1000,
        "nerf-frames.json": nerf.format(n=1280, f=",".join([frame] * 9)),
        "kalibr.yaml": "".join(f"cam{i}: &c {{camera_model: pinhole}}\n" for i in range(30)),
        "kalibr-numbers.yaml": "cam0: {camera_model: pinhole, intrinsics: [" + "1," * 400 + "1]}\n",
        "basalt.json": '{"value0": {"intrinsics": [' + '{"camera_type": "kb4"},' * 40 + "{}]}}",
        "ros.yaml": "image_width: 1280\nimage_height: 800\ncamera_name: a\ndistortion_model: "
                    "plumb_bob\ncamera_matrix: {rows: 3, cols: 3, data: [" + "1," * 300 + "1]}\n",
        "cahvor.cahvor": "Model = CAHVOR" + "E" * 900,
        "covariance.yaml": size.format(w=1280, h=800) + ok + "covariance: {rows: 100000, cols: "
                           "100000, dt: d, data: [1]}\ncovariance_names: [fx]\n",
        "uncertainty.yaml": size.format(w=1280, h=800) + ok + "projection_uncertainty:\n"
                            + "- {distance_m: 1, sigma_px: {rows: 50000, cols: 50000, data: [1]}}\n"}
    for i, n in enumerate(HUGE):
        files |= {f"size-{i}.yaml": size.format(w=n, h=n) + ok, f"nerf-{i}.json": nerf.format(n=n, f=""),
                  f"rows-{i}.yaml": size.format(w=640, h=400) + matrix.format(r=n, c=n),
                  f"colmap-{i}.txt": colmap.format(w=n, h=n),
                  f"coefficients-{i}.yaml": size.format(w=640, h=400) + ok + "distortion_coefficients:"
                                            f" {{rows: 1, cols: 5, data: [{n}, {n}, {n}, {n}, {n}]}}\n"}
    return files


def tables():
    """CSV and lists: corners, points, vnl, poses."""
    return {
        "quotes.csv": 'image,tag_id,corner,x_px,y_px\n"' + '""' * 450,
        "commas.csv": "image,tag_id,corner,x_px,y_px\n" + "," * 900,
        "columns.csv": "x_m,y_m,z_m," * 80 + "\n" + "1," * 200, "points.csv": "x_m,y_m,z_m\n" + "1e308,"
        "1e308,1e308\n" * 40, "pixels.csv": "u_px,v_px\n" + "1e308,-1e308\n" * 60,
        "numbers.csv": "image,tag_id,corner,x_px,y_px\na,9999999999,9,1e308,1e308\n",
        "huge.csv": "image,tag_id,corner,x_px,y_px\n" + "".join(
            f"a{i}.png,0,0,1e308,-1e308\n" for i in range(35)),
        "lines.csv": "\n" * 1000, "carriage.csv": "\r" * 1000, "spaces.csv": " " * 1000,
        "corners.vnl": "# filename x y level\n" + "a 1e308 1e308 2147483647\n" * 35,
        "binary.csv": "image,tag_id,corner,x_px,y_px\n" + "\0\1\2\x7f" * 200,
        "poses.json": '{"views": [' + '{"image": "a", "camera_from_board": {"rotation": [1,0,0,0]}},'
                      * 14 + "{}]}", "poses-nested.json": '{"views": ' + "[" * 900,
        "poses-huge.json": '{"views": [{"image": "a", "camera_from_board": {"translation_m": '
                           "[1e308, 1e308, 1e308]}}]}"}
