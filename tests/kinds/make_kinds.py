#!/usr/bin/env python3
"""Makes the small pictures of this folder, one of each kind of file, and `expected.txt`: what is right for each.

Needs numpy, tifffile, imagecodecs and Pillow. The right values are computed here from the numbers that are put into
the files, not by any reader:

    FILE COLUMNS ROWS TOLERANCE ALPHA     ALPHA is `alpha` or `opaque`
    X Y RED GREEN BLUE ALPHA              some of its pixels: linear light, multiplied by alpha
"""

import io
import lzma
import struct
import zlib
from pathlib import Path

import numpy as np
import tifffile
from PIL import Image, TiffImagePlugin

HERE = Path(__file__).parent
W, H = 7, 5
lines = []


def light(v):
    v = np.asarray(v, np.float64)
    a = np.abs(v)
    return np.copysign(np.where(a <= 0.04045, a / 12.92, ((a + 0.055) / 1.055) ** 2.4), v)


def expect(name, color, alpha=None, tolerance=1e-6):
    """`color` is linear and multiplied already."""
    color = np.asarray(color, np.float64)
    if color.ndim == 2:
        color = color[..., None]
    if color.shape[2] == 1:
        color = np.repeat(color, 3, 2)
    h, w = color.shape[:2]
    lines.append(f"{name} {w} {h} {tolerance:g} {'opaque' if alpha is None else 'alpha'}")
    for x, y in sorted({(0, 0), (w - 1, 0), (0, h - 1), (w - 1, h - 1), (w // 2, h // 3)}):
        a = 1.0 if alpha is None else alpha[y, x]
        lines.append(f"{x} {y} " + " ".join(f"{v:.9g}" for v in [*color[y, x], a]))


def unit(*channels, w=W, h=H):
    """Numbers from 0 to 1, other ones in each channel."""
    y, x = np.mgrid[0:h, 0:w]
    return np.stack([((x * (3 + 2 * c) + y * (5 + c) + 2 * c) % 17) / 16 for c in channels], -1)


def codes(v, bits):
    return np.rint(v * (2**bits - 1)).astype(np.uint8 if bits <= 8 else np.uint16 if bits <= 16 else np.uint32)


def norm(c, bits):
    return c.astype(np.float64) / (2**bits - 1)


def tiff(name, data, **more):
    more.setdefault("metadata", None)
    tifffile.imwrite(HERE / name, data, **more)


# --- alpha ---------------------------------------------------------------------------------------------------------
rgb, a = unit(0, 1, 2), 0.25 + 0.75 * unit(3)[..., 0]
for bits in (8, 16):
    alpha = codes(a, bits)
    straight = codes(rgb, bits)
    over = np.minimum(codes(rgb * a[..., None], bits), alpha[..., None])
    al = norm(alpha, bits)[..., None]
    both = np.dstack([straight, alpha])
    tiff(f"alpha_straight_{bits}.tif", both, photometric="rgb", extrasamples=["unassalpha"])
    expect(f"alpha_straight_{bits}.tif", light(norm(straight, bits)) * al, al[..., 0])
    multiplied = np.dstack([over, alpha])
    tiff(f"alpha_multiplied_{bits}.tif", multiplied, photometric="rgb", extrasamples=["assocalpha"])
    expect(f"alpha_multiplied_{bits}.tif", light(norm(over, bits) / al) * al, al[..., 0])
    grey = np.dstack([over[..., 0], alpha])
    tiff(f"alpha_multiplied_grey_{bits}.tif", grey, photometric="minisblack", extrasamples=["assocalpha"])
    expect(f"alpha_multiplied_grey_{bits}.tif", light(norm(over[..., :1], bits) / al) * al, al[..., 0])
unspecified = np.dstack([codes(rgb, 8), codes(a, 8)])
tiff("sample_unspecified.tif", unspecified, photometric="rgb", extrasamples=["unspecified"], predictor=2, compression="lzw")
expect("sample_unspecified.tif", light(norm(codes(rgb, 8), 8)))
five = np.dstack([codes(rgb, 8), codes(a, 8), codes(rgb[..., 0], 8)])
tiff("alpha_last_of_five.tif", five[..., [0, 1, 2, 4, 3]], photometric="rgb", extrasamples=["unspecified", "unassalpha"])
expect("alpha_last_of_five.tif", light(norm(codes(rgb, 8), 8)) * norm(codes(a, 8), 8)[..., None], norm(codes(a, 8), 8))
for kind in ("unassalpha", "assocalpha"):
    f = np.dstack([rgb, a]).astype(np.float32)
    tiff(f"float_{kind}.tif", f, photometric="rgb", extrasamples=[kind])
    expect(f"float_{kind}.tif", f[..., :3] * (f[..., 3:] if kind == "unassalpha" else 1), f[..., 3])

# --- numbers -------------------------------------------------------------------------------------------------------
for bits in (16, 32, 64):
    dtype = {16: np.float16, 32: np.float32, 64: np.float64}[bits]
    f = (unit(0, 1, 2) * 3 - 1).astype(dtype)
    for name, data, photometric in (("grey", f[..., 0], "minisblack"), ("rgb", f, "rgb")):
        tiff(f"float{bits}_{name}.tif", data, photometric=photometric)
        expect(f"float{bits}_{name}.tif", data)
    tiff(f"float{bits}_predictor3.tif", f, photometric="rgb", predictor=3, compression="zlib", byteorder="<>"[bits == 32])
    expect(f"float{bits}_predictor3.tif", f)
for layout in ("contig", "separate"):
    c = codes(unit(0, 1, 2), 32)
    data = c if layout == "contig" else np.moveaxis(c, -1, 0)
    tiff(f"int32_{layout}.tif", np.ascontiguousarray(data), photometric="rgb", planarconfig=layout, byteorder=">" if layout == "contig" else "<")
    expect(f"int32_{layout}.tif", light(norm(c, 32)))
signed = np.rint(unit(0)[..., 0] * 65534 - 32767).astype(np.int16)
tiff("signed16_grey.tif", signed, photometric="minisblack")
expect("signed16_grey.tif", light(signed / 32767.0))


def raw_tiff(name, width, height, entries, data, order="<"):
    """A TIFF of one strip from tags; `entries` is a list of (tag, type, values)."""
    entries = sorted(entries + [(256, 3, [width]), (257, 3, [height]), (273, 4, [0]), (278, 3, [height]), (279, 4, [len(data)])])
    size = {1: 1, 3: 2, 4: 4, 5: 8, 7: 1}
    letter = {1: "B", 3: "H", 4: "I", 5: "I", 7: "B"}
    start = 8 + len(data) + len(data) % 2
    extra_at = start + 2 + 12 * len(entries) + 4
    table, extra = b"", b""
    for tag, kind, values in entries:
        values = [8] if tag == 273 else values
        count = len(values) // 2 if kind == 5 else len(values)
        packed = struct.pack(order + letter[kind] * len(values), *values)
        if len(packed) <= 4:
            field = packed.ljust(4, b"\0")
        else:
            field = struct.pack(order + "I", extra_at + len(extra))
            extra += packed + b"\0" * (len(packed) % 2)
        table += struct.pack(order + "HHI", tag, kind, count) + field
    head = (b"II" if order == "<" else b"MM") + struct.pack(order + "HI", 42, start)
    (HERE / name).write_bytes(head + data + b"\0" * (len(data) % 2) + struct.pack(order + "H", len(entries)) + table + b"\0\0\0\0" + extra)


def packed_bits(rows, bits):
    """Rows of codes, each from a whole byte."""
    out = b""
    for row in rows.reshape(rows.shape[0], -1):
        text = "".join(format(int(v), f"0{bits}b") for v in row)
        text += "0" * (-len(text) % 8)
        out += bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))
    return out


for bits in (1, 2, 4, 6, 10, 12, 14):
    c = codes(unit(0)[..., 0], bits)
    for name, photometric in (("", 1), ("_white_is_0", 0)):
        if name and bits not in (1, 12):
            continue
        raw_tiff(f"grey{bits}{name}.tif", W, H, [(258, 3, [bits]), (262, 3, [photometric])], packed_bits(c, bits), "<>"[bits % 4 == 0])
        expect(f"grey{bits}{name}.tif", light(norm(c, bits) if photometric else 1 - norm(c, bits)))
c24 = np.rint(unit(0)[..., 0] * (2**24 - 1)).astype(np.uint32)
raw_tiff("grey24.tif", W, H, [(258, 3, [24]), (262, 3, [1])], b"".join(int(v).to_bytes(3, "big") for v in c24.flat))
expect("grey24.tif", light(c24 / (2**24 - 1)))
c = codes(unit(0, 1, 2), 12)
raw_tiff("rgb12.tif", W, H, [(258, 3, [12] * 3), (262, 3, [2]), (277, 3, [3])], packed_bits(c, 12))
expect("rgb12.tif", light(norm(c, 12)))

f = unit(0, 1, 2).astype(np.float16)
differences = f.view(np.uint16).copy()
differences[:, 1:] -= f.view(np.uint16)[:, :-1]
entries = [(258, 3, [16] * 3), (259, 3, [8]), (262, 3, [2]), (277, 3, [3]), (317, 3, [2]), (339, 3, [3] * 3)]
raw_tiff("float16_predictor2.tif", W, H, entries, zlib.compress(differences.tobytes()))
expect("float16_predictor2.tif", f)

c = codes(unit(0)[..., 0], 12)
differences = c.copy()
differences[:, 1:] -= c[:, :-1]
raw_tiff("grey12_predictor2.tif", W, H, [(258, 3, [12]), (259, 3, [8]), (262, 3, [1]), (317, 3, [2])], zlib.compress(packed_bits(differences % 4096, 12)))
expect("grey12_predictor2.tif", light(norm(c, 12)))

# --- meanings of samples -------------------------------------------------------------------------------------------
for bits in (1, 2, 4, 8, 16):
    count = 2**bits
    index = (np.arange(W * H).reshape(H, W) * 7919) % count
    ramp = np.arange(count, dtype=np.int64)
    table = np.stack([ramp * 40503 % 65536, ramp * 25931 % 65536, (65535 - ramp * 313) % 65536])
    if bits == 4:
        table = table // 257 * 257
    if bits == 2:
        table = table // 256 * 256
    if bits == 16:
        # One of 16 bits is large; packed it is small.
        table = table // 8192 * 8192
    map_ = [int(v) for v in table.flat]
    raw = packed_bits(index, bits) if bits < 16 else index.astype("<u2").tobytes()
    if bits == 16:
        tiff("palette16.tif", index.astype(np.uint16), photometric="palette", colormap=np.asarray(table, np.uint16), compression="zlib")
        blob = (HERE / "palette16.tif").read_bytes()
        (HERE / "palette16.tif").unlink()
        if len(blob) > 20000:
            continue
        (HERE / "palette16.tif").write_bytes(blob)
    else:
        raw_tiff(f"palette{bits}.tif", W, H, [(258, 3, [bits]), (262, 3, [3]), (320, 3, map_)], raw)
    whole = all(v % 256 == 0 for v in map_)
    colors = np.moveaxis(table, 0, -1)[index]
    expect(f"palette{bits}.tif", light(colors // 256 / 255 if whole else colors / 65535))
index = (np.arange(W * H).reshape(H, W) * 3) % 16
table = np.stack([np.arange(256) % 16 * 17] * 3) * 257
both = np.dstack([index, codes(a, 8)]).astype(np.uint8)
raw_tiff("palette8_alpha.tif", W, H, [(258, 3, [8, 8]), (262, 3, [3]), (277, 3, [2]), (320, 3, [int(v) for v in table.flat]), (338, 3, [2])], both.tobytes())
expect("palette8_alpha.tif", light(index * 17 / 255)[..., None].repeat(3, 2) * norm(both[..., 1], 8)[..., None], norm(both[..., 1], 8))
for layout in ("contig", "separate"):
    c = codes(unit(0, 1, 2, 3), 8)
    tiff(f"cmyk_{layout}.tif", np.ascontiguousarray(c if layout == "contig" else np.moveaxis(c, -1, 0)), photometric="separated", planarconfig=layout)
    n = norm(c, 8)
    expect(f"cmyk_{layout}.tif", light((1 - n[..., :3]) * (1 - n[..., 3:])))
f = unit(0, 1, 2, 3).astype(np.float32)
tiff("cmyk_float.tif", f, photometric="separated")
expect("cmyk_float.tif", (1 - f[..., :3]) * (1 - f[..., 3:]))


def from_lab(lightness, a_, b_):
    """CIE L*a*b* of D50 as linear sRGB, by the published matrix that has Bradford's adaptation in it."""
    y = (lightness + 16) / 116
    f = np.stack([y + a_ / 500, y, y - b_ / 200], -1)
    xyz = np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29)) * [0.9642, 1, 0.8249]
    m = np.array([[3.1338561, -1.6168667, -0.4906146], [-0.9787684, 1.9161415, 0.0334540], [0.0719453, -0.2289914, 1.4052427]])
    return xyz @ m.T


lab = np.dstack([codes(unit(0)[..., 0], 8), codes(0.3 * unit(1)[..., 0], 8), codes(1 - 0.2 * unit(2)[..., 0], 8)])
ab, wide = lab.astype(np.int8).astype(float), lab.astype(float)
raw_tiff("lab8.tif", W, H, [(258, 3, [8] * 3), (262, 3, [8]), (277, 3, [3])], lab.tobytes())
expect("lab8.tif", from_lab(wide[..., 0] * 100 / 255, ab[..., 1], ab[..., 2]), tolerance=2e-3)
raw_tiff("icclab8.tif", W, H, [(258, 3, [8] * 3), (262, 3, [9]), (277, 3, [3])], lab.tobytes())
expect("icclab8.tif", from_lab(wide[..., 0] * 100 / 255, wide[..., 1] - 128, wide[..., 2] - 128), tolerance=2e-3)


def from_ycbcr(y, cb, cr, weights=(0.299, 0.587, 0.114)):
    r = y + (2 - 2 * weights[0]) * (cr - 128) * 127 / 127
    b = y + (2 - 2 * weights[2]) * (cb - 128)
    g = (y - weights[0] * r - weights[2] * b) / weights[1]
    return np.clip(np.stack([r, g, b], -1), 0, 255) / 255


luma = np.rint(60 + 100 * unit(0, w=6, h=4)[..., 0]).astype(np.uint8)
for across, down in ((1, 1), (2, 1), (2, 2), (4, 2)):
    bw, bh = -(-6 // across), -(-4 // down)
    cb = np.rint(110 + 40 * unit(1, w=bw, h=bh)[..., 0]).astype(np.uint8)
    cr = np.rint(100 + 50 * unit(2, w=bw, h=bh)[..., 0]).astype(np.uint8)
    padded = np.zeros((bh * down, bw * across), np.uint8)
    padded[:4, :6] = luma
    data = b""
    for by in range(bh):
        for bx in range(bw):
            data += padded[by * down : (by + 1) * down, bx * across : (bx + 1) * across].tobytes()
            data += bytes([cb[by, bx], cr[by, bx]])
    weights = [2125, 10000, 7154, 10000, 721, 10000] if across == 4 else [299, 1000, 587, 1000, 114, 1000]
    raw_tiff(f"ycbcr_{across}x{down}.tif", 6, 4, [(258, 3, [8] * 3), (262, 3, [6]), (277, 3, [3]), (529, 5, weights), (530, 3, [across, down])], data)
    up = lambda c: c.repeat(across, 1).repeat(down, 0)[:4, :6].astype(float)
    w3 = [weights[i] / weights[i + 1] for i in (0, 2, 4)]
    # Readers round to 8 bits.
    expect(f"ycbcr_{across}x{down}.tif", light(np.rint(255 * from_ycbcr(luma.astype(float), up(cb), up(cr), w3)) / 255), tolerance=0.006)

# --- compressions, tiles, BigTIFF ----------------------------------------------------------------------------------
c = codes(unit(0, 1, 2, w=21, h=19), 8)
for name, more in {
    "lzw": dict(compression="lzw", predictor=2),
    "deflate": dict(compression="zlib", rowsperstrip=4),
    "packbits": dict(compression="packbits"),
    "zstd": dict(compression="zstd"),
    "lzma": dict(compression="lzma"),
    "webp": dict(compression="webp", compressionargs=dict(lossless=True)),
    "tiled": dict(tile=(16, 16), compression="lzw"),
    "big": dict(bigtiff=True),
    "big_motorola": dict(bigtiff=True, byteorder=">", tile=(16, 16)),
}.items():
    tiff(f"packed_{name}.tif", c, photometric="rgb", **more)
    expect(f"packed_{name}.tif", light(norm(c, 8)))
filters = [dict(id=lzma.FILTER_DELTA, dist=3), dict(id=lzma.FILTER_LZMA2, preset=6)]
blob = lzma.compress(c.tobytes(), lzma.FORMAT_XZ, lzma.CHECK_CRC32, filters=filters)
raw_tiff("packed_lzma_delta.tif", 21, 19, [(258, 3, [8] * 3), (259, 3, [34925]), (262, 3, [2]), (277, 3, [3])], blob)
expect("packed_lzma_delta.tif", light(norm(c, 8)))
c16 = codes(unit(0, 1, 2), 16)
tiff("predictor2_16_motorola.tif", c16, photometric="rgb", predictor=2, compression="lzw", byteorder=">")
expect("predictor2_16_motorola.tif", light(norm(c16, 16)))
ten = np.moveaxis(unit(*range(10)), -1, 0).astype(np.float32)
tiff("float32_ten_samples.tif", np.ascontiguousarray(np.moveaxis(ten, 0, -1)), photometric="minisblack", planarconfig="contig")
expect("float32_ten_samples.tif", ten[0])

bits = np.zeros((24, 43), np.uint8)
bits[3:20, 5:37] = 1
bits[6:12, 9:30] = 0
bits[::5, ::3] ^= 1
for name, method in (("g3", "group3"), ("g4", "group4"), ("huffman", "tiff_ccitt")):
    Image.fromarray(bits * 255).convert("1").save(HERE / f"fax_{name}.tif", compression=method)
    expect(f"fax_{name}.tif", bits)
info = TiffImagePlugin.ImageFileDirectory_v2()
info[292] = 5
Image.fromarray(bits * 255).convert("1").save(HERE / "fax_g3_2d_fill.tif", compression="group3", tiffinfo=info)
expect("fax_g3_2d_fill.tif", bits)



def slope(w, h):
    """Colours that JPEG keeps, and the same as YCbCr."""
    y, x = np.mgrid[0:h, 0:w]
    rgb = np.stack([60 + 5 * x, 200 - 4 * y, 40 + 3 * x + 2 * y], -1).astype(np.uint8)
    to = [[0.299, -0.168736, 0.5], [0.587, -0.331264, -0.418688], [0.114, 0.5, -0.081312]]
    return rgb, np.rint(rgb.astype(float) @ to + [0, 128, 128]).astype(np.uint8)


smooth, _ = slope(20, 24)
for name, size, more in (
    ("rgb", (20, 24), dict(photometric="rgb")),
    ("ycbcr", (20, 24), dict(photometric="ycbcr")),
    ("ycbcr_subsampled", (20, 24), dict(photometric="ycbcr", subsampling=(2, 2))),
    ("tiled", (32, 32), dict(photometric="ycbcr", subsampling=(2, 2), tile=(16, 16))),
):
    given, converted = slope(*size)
    data = given if name == "rgb" else converted
    tiff(f"jpeg_{name}.tif", data, compression="jpeg", compressionargs=dict(level=95), **more)
    expect(f"jpeg_{name}.tif", light(given / 255), tolerance=0.03)
Image.fromarray(smooth).save(HERE / "jpeg_tables.tif", compression="jpeg", quality=95)
expect("jpeg_tables.tif", light(smooth / 255), tolerance=0.03)
stream = io.BytesIO()
Image.fromarray(smooth).save(stream, "JPEG", quality=95, subsampling=2)
stream = stream.getvalue()
old = [(258, 3, [8] * 3), (259, 3, [6]), (262, 3, [6]), (277, 3, [3]), (513, 4, [8]), (514, 4, [len(stream)]), (530, 3, [2, 2])]
raw_tiff("old_jpeg_stream.tif", 20, 24, old, stream)
expect("old_jpeg_stream.tif", light(smooth / 255), tolerance=0.03)

# --- orientation ---------------------------------------------------------------------------------------------------


def turned(v, o):
    for one, f in {2: lambda v: v[:, ::-1], 3: lambda v: v[::-1, ::-1], 4: lambda v: v[::-1], 5: lambda v: v.swapaxes(0, 1),
                   6: lambda v: np.rot90(v, -1), 7: lambda v: v[::-1, ::-1].swapaxes(0, 1), 8: lambda v: np.rot90(v, 1)}.items():
        if one == o:
            return f(v)
    return v


c = codes(unit(0, 1, 2), 8)
for o in range(2, 9):
    tiff(f"turned_{o}.tif", c, photometric="rgb", extratags=[(274, 3, 1, o, True)])
    expect(f"turned_{o}.tif", turned(light(norm(c, 8)), o))


def exif(o):
    e = Image.Exif()
    e[274] = o
    return e


for o in (3, 6):
    Image.fromarray(smooth).save(HERE / f"turned_{o}.jpg", exif=exif(o), quality=95)
    expect(f"turned_{o}.jpg", turned(light(smooth / 255), o), tolerance=0.03)
    Image.fromarray(c).save(HERE / f"turned_{o}.png", exif=exif(o))
    expect(f"turned_{o}.png", turned(light(norm(c, 8)), o))
    Image.fromarray(c).save(HERE / f"turned_{o}.webp", exif=exif(o), lossless=True)
    expect(f"turned_{o}.webp", turned(light(norm(c, 8)), o))
Image.fromarray(c).save(HERE / "turned_5_text.png")
blob = (HERE / "turned_5_text.png").read_bytes()
block = exif(5).tobytes()
text = zlib.compress(f"\nexif\n{len(block):8}\n{block.hex()}\n".encode())
content = b"zTXtRaw profile type exif\0\0" + text
chunk = struct.pack(">I", len(content) - 4) + content + struct.pack(">I", zlib.crc32(content))
(HERE / "turned_5_text.png").write_bytes(blob[:-12] + chunk + blob[-12:])
expect("turned_5_text.png", turned(light(norm(c, 8)), 5))

# --- TGA, BMP, HDR -------------------------------------------------------------------------------------------------


def tga(name, kind, bits, descriptor, data, w=W, h=H, attribute=None, palette=(0, 0, b"")):
    first, entry, table = palette
    count = len(table) // (entry // 8) if entry else 0
    head = struct.pack("<BBBHHBHHHHBB", 0, int(count > 0), kind, first, count, entry, 0, 0, w, h, bits, descriptor)
    body = head + table + data
    if attribute is not None:
        area = struct.pack("<H", 495) + b"\0" * 492 + bytes([attribute])
        body += area + struct.pack("<II", len(body), 0) + b"TRUEVISION-XFILE.\0"
    (HERE / name).write_bytes(body)


straight, alpha = codes(rgb, 8), codes(a, 8)
al = norm(alpha, 8)[..., None]
over = np.minimum(codes(rgb * a[..., None], 8), alpha[..., None])
bgra = lambda c: np.dstack([c[..., ::-1], alpha]).tobytes()
for name, descriptor, attribute, data, color, kept in (
    ("tga_alpha.tga", 0x28, None, straight, light(norm(straight, 8)) * al, True),
    ("tga_no_alpha_bits.tga", 0x20, None, straight, light(norm(straight, 8)), False),
    ("tga_attribute_0.tga", 0x28, 0, straight, light(norm(straight, 8)), False),
    ("tga_attribute_2.tga", 0x28, 2, straight, light(norm(straight, 8)), False),
    ("tga_attribute_3.tga", 0x28, 3, straight, light(norm(straight, 8)) * al, True),
    ("tga_attribute_4.tga", 0x28, 4, over, light(norm(over, 8) / al) * al, True),
):
    tga(name, 2, 32, descriptor, bgra(data), attribute=attribute)
    expect(name, color, al[..., 0] if kept else None)
five = codes(rgb, 5).astype(np.uint16)
bit = (np.arange(W * H).reshape(H, W) % 3 == 0).astype(np.uint16)
words = (bit << 15 | five[..., 0] << 10 | five[..., 1] << 5 | five[..., 2]).astype("<u2")
shown = light(np.rint(five * 255 / 31) / 255)
for descriptor, kept in ((0x20, False), (0x21, True), (0x28, True)):
    tga(f"tga_16_{descriptor:x}.tga", 2, 16, descriptor, words.tobytes())
    clear = (1 - bit)[..., None]
    expect(f"tga_16_{descriptor:x}.tga", shown * (clear if kept else 1), 1.0 - bit if kept else None)
packets = b""
for row in straight[::-1]:
    packets += bytes([W - 1]) + row[:, ::-1].tobytes()
tga("tga_packed.tga", 10, 24, 0, packets)
expect("tga_packed.tga", light(norm(straight, 8)))
run = bytes([0x80 | (W * H - 1)]) + bytes([10, 20, 30])
tga("tga_run.tga", 10, 24, 0x20, run)
expect("tga_run.tga", light(np.full((H, W, 3), [30, 20, 10]) / 255))
tga("tga_right_to_left.tga", 2, 24, 0x30, straight[:, ::-1, ::-1].tobytes())
expect("tga_right_to_left.tga", light(norm(straight, 8)))
tga("tga_grey_alpha.tga", 3, 16, 0x28, np.dstack([straight[..., 0], alpha]).tobytes())
expect("tga_grey_alpha.tga", light(norm(straight[..., :1], 8)) * al, al[..., 0])
table = np.arange(48, dtype=np.uint8).reshape(16, 3) * 5
index = (np.arange(W * H).reshape(H, W) % 16).astype(np.uint8)
tga("tga_palette.tga", 1, 8, 0x20, (index + 4).tobytes(), palette=(4, 24, table.tobytes()))
expect("tga_palette.tga", light(table[index][..., ::-1] / 255))

stride = (W + 3) // 4 * 4
pixels = b"".join(row.tobytes().ljust(stride, b"\0") for row in index[::-1])
quads = b"".join(entry.tobytes() + b"\0" for entry in table)
header = struct.pack("<IiiHHIIiiII", 64, W, H, 1, 8, 0, 0, 0, 0, 16, 0) + b"\0" * 24
offset = 14 + len(header) + len(quads)
(HERE / "os2_2.bmp").write_bytes(b"BM" + struct.pack("<IHHI", offset + len(pixels), 0, 0, offset) + header + quads + pixels)
expect("os2_2.bmp", light(table[index][..., ::-1] / 255))

rgbe = np.dstack([codes(unit(0, 1, 2), 8), np.full((H, W), 129, np.uint8)])
decoded = rgbe[..., :3] * (2.0 ** (129 - 128) / 256)
for name, magic, resolution, o in (
    ("rgbe.hdr", "RGBE", f"-Y {H} +X {W}", 1),
    ("rgbe_upwards.hdr", "RADIANCE", f"+Y {H} +X {W}", 4),
    ("rgbe_columns.hdr", "RADIANCE", f"-X {H} -Y {W}", 6),
):
    (HERE / name).write_bytes(f"#?{magic}\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n{resolution}\n".encode() + rgbe.tobytes())
    expect(name, turned(decoded, o), tolerance=0.004)

(HERE / "expected.txt").write_text("\n".join(lines) + "\n")
