#!/usr/bin/python3
"""Draws a mesh (PLY) as a PNG, from outside or through a camera of the run.

scripts/render_mesh.py mesh.ply out.png --from X Y Z --to X Y Z [--by grey|normal|plane|error --truth SEQUENCE]
scripts/render_mesh.py mesh.ply out.png --pose 't tx ty tz qx qy qz qw'    # T_WB, EuRoC's left camera
"""

import argparse
import struct
import zlib

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

T_BC0 = np.array([[0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975],
                  [0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768],
                  [-0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949],
                  [0, 0, 0, 1]])
TYPES = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4", "uint": "u4", "short": "i2"}


def read_ply(path):
    """Vertices, faces, grey values, plane ids of a binary PLY with triangles."""
    with open(path, "rb") as stream:
        data = stream.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    count, properties, element = {}, {}, None
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == "element":
            element = words[1]
            count[element] = int(words[2])
            properties[element] = []
        elif words[0] == "property" and words[1] != "list":
            properties[element].append((words[2], "<" + TYPES[words[1]]))
    vertex = np.frombuffer(data, np.dtype(properties["vertex"]), count["vertex"], end)
    xyz = np.stack([vertex[k].astype(float) for k in "xyz"], axis=1)
    grey = vertex["red"] if "red" in vertex.dtype.names else np.full(len(xyz), 160)
    if not count.get("face"):
        return xyz, np.zeros((0, 3), int), grey, np.zeros(0, int)
    face_type = np.dtype([("n", "u1"), ("v", "<i4", 3)] + properties["face"])
    face = np.frombuffer(data, face_type, count["face"], end + vertex.nbytes)
    ids = face["plane_id"] if "plane_id" in face.dtype.names else np.full(len(face), -1)
    return xyz, face["v"].astype(int), grey, ids


def write_png(path, image):
    height, width = image.shape[:2]
    rows = b"".join(b"\0" + image[y].tobytes() for y in range(height))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    with open(path, "wb") as stream:
        stream.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def look_at(eye, target):
    z = target - eye
    z /= np.linalg.norm(z)
    x = np.cross(z, [0, 0, 1])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z])
    return R, -R @ eye


def quaternion_to_matrix(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def camera_of(pose):
    t = np.array(pose.split(), float)
    T_WB = np.eye(4)
    T_WB[:3, :3] = quaternion_to_matrix(*t[4:8])
    T_WB[:3, 3] = t[1:4]
    T_CW = np.linalg.inv(T_WB @ T_BC0)
    return T_CW[:3, :3], T_CW[:3, 3]


def rasterise(xyz_C, faces, colours, focal, centre, size, edges, backs):
    """Z-buffer; `backs`: draw faces seen from behind, too (dark red)."""
    width, height = size
    image = np.full((height, width, 3), 255, np.uint8)
    depth = np.full((height, width), np.inf)
    for f, (i, j, k) in enumerate(faces):
        p = xyz_C[[i, j, k]]
        if p[:, 2].min() < 0.05:
            continue
        u = focal * p[:, :2] / p[:, 2:] + centre
        x0, y0 = np.maximum(np.floor(u.min(0)).astype(int), 0)
        x1, y1 = np.minimum(np.ceil(u.max(0)).astype(int) + 1, [width, height])
        if x0 >= x1 or y0 >= y1:
            continue
        e1, e2 = u[1] - u[0], u[2] - u[0]
        area = e1[0] * e2[1] - e1[1] * e2[0]
        if abs(area) < 1e-9 or (area > 0 and not backs):
            continue
        xs, ys = np.meshgrid(np.arange(x0, x1) - u[0][0], np.arange(y0, y1) - u[0][1])
        b1 = (xs * e2[1] - ys * e2[0]) / area
        b2 = (e1[0] * ys - e1[1] * xs) / area
        b0 = 1 - b1 - b2
        inside = (b0 >= 0) & (b1 >= 0) & (b2 >= 0)
        z = 1 / np.maximum(b0 / p[0, 2] + b1 / p[1, 2] + b2 / p[2, 2], 1e-9)
        part = depth[y0:y1, x0:x1]
        nearer = inside & (z < part)
        part[nearer] = z[nearer]
        colour = colours[f] if area < 0 else (120, 40, 40)
        image[y0:y1, x0:x1][nearer] = colour
        if edges:
            # Barycentric coordinate over its gradient is the distance from the side, in pixels.
            sides = np.linalg.norm([u[2] - u[1], e2, e1], axis=1)
            near = np.minimum.reduce([b * abs(area) / s for b, s in zip((b0, b1, b2), sides)]) < 0.6
            image[y0:y1, x0:x1][nearer & near] = (30, 30, 30)
    return image


def face_colours(args, xyz, faces, grey, ids):
    a, b, c = (xyz[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    if args.by == "normal":
        return (127.5 + 127.5 * normal).astype(np.uint8)
    shade = (0.45 + 0.55 * np.abs(normal @ np.array([0.36, 0.48, 0.8])))[:, None]
    if args.by == "plane":
        palette = np.random.default_rng(3).integers(60, 255, (64, 3))
        base = np.where(ids[:, None] >= 0, palette[ids % 64], 180)
        return (base * shade).astype(np.uint8)
    if args.by == "error":
        from scipy.spatial import cKDTree
        truth = read_ply(args.truth + "/mav0/pointcloud0/data.ply")[0]
        pose = np.array(args.align.split(), float)
        centre = (a + b + c) / 3 @ quaternion_to_matrix(*pose[3:7]).T + pose[:3]
        error = np.clip(cKDTree(truth).query(centre)[0] / 0.10, 0, 1)[:, None]
        return (255 * np.hstack([error, 1 - error, 0.2 + 0 * error]) * shade).astype(np.uint8)
    tone = grey[faces].mean(axis=1)[:, None]
    return np.repeat(np.clip(tone * (0.6 + 0.4 * shade), 0, 255), 3, axis=1).astype(np.uint8)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("png")
    parser.add_argument("--from", dest="eye", nargs=3, type=float)
    parser.add_argument("--to", dest="target", nargs=3, type=float)
    parser.add_argument("--pose", help="line of a TUM file: T_WB; shows what the left camera sees there")
    parser.add_argument("--by", choices=("grey", "normal", "plane", "error"), default="grey")
    parser.add_argument("--truth", help="sequence with mav0/pointcloud0, for --by error")
    parser.add_argument("--align", default="0 0 0 0 0 0 1", help="T_GW as 'x y z qx qy qz qw', for --by error")
    parser.add_argument("--size", nargs=2, type=int, default=(752, 480))
    parser.add_argument("--focal", type=float, default=458)
    parser.add_argument("--edges", action="store_true")
    parser.add_argument("--backs", action="store_true", help="also faces seen from behind, in dark red")
    args = parser.parse_args()
    if not args.pose and not (args.eye and args.target):
        parser.error("say where from: --pose, or --from and --to")
    xyz, faces, grey, ids = read_ply(args.mesh)
    if args.pose:
        R, t = camera_of(args.pose)
    else:
        R, t = look_at(np.array(args.eye), np.array(args.target))
    colours = face_colours(args, xyz, faces, grey, ids)
    image = rasterise(xyz @ R.T + t, faces, colours, args.focal, np.array(args.size) / 2, args.size,
                      args.edges, args.backs)
    write_png(args.png, image)


if __name__ == "__main__":
    main()
