"""Small files that claim to be large pictures: name -> bytes."""

import lzma
import struct
import zlib


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, bits=8, colour=0, interlaced=0, data=b"", before=b""):
    header = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, interlaced)
    return (b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + before + png_chunk(b"IDAT", data)
            + png_chunk(b"IEND", b""))


def bomb(megabytes):
    """Zeros, deflated: 1 kB for 1 MB, and a few bytes more where it is deflated twice."""
    return zlib.compress(b"\0" * (megabytes << 20), 9)


def jpeg(width, height, kind=0xC0, scans=1):
    """A JPEG whose data end at once; `kind` 0xc2: progressive, 0xc9: arithmetic."""
    frame = struct.pack(">BHHB", 8, height, width, 3) + bytes([1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0])
    table = bytes([0] + [1] + [0] * 15 + [0])
    ac_table = bytes([0x10] + [1] + [0] * 15 + [0])
    scan = bytes([3, 1, 0, 2, 0, 3, 0, 0, 0 if kind == 0xC2 else 63, 0])

    def segment(marker, data):
        return bytes([0xFF, marker]) + struct.pack(">H", len(data) + 2) + data

    return (b"\xff\xd8" + segment(0xDB, bytes([0] + [1] * 64)) + segment(kind, frame)
            + (b"" if kind >= 0xC9 else segment(0xC4, table) + segment(0xC4, ac_table))
            + (segment(0xDA, scan) + b"\0" * 4) * scans + b"\xff\xd9")


def tiff(entries, data=b"", next_directory=0, magic=b"II*\0"):
    """A TIFF with one directory: (tag, type, count, value), in order of tags."""
    body = struct.pack("<H", len(entries))
    for tag, kind, count, value in entries:
        body += struct.pack("<HHII", tag, kind, count, value)
    return magic + struct.pack("<I", 8) + body + struct.pack("<I", next_directory) + data


def tiff_picture(width, height, bits=8, samples=1, compression=1, strip_rows=None, strips=1, **rest):
    """`strips` is the claimed number of offsets, which are behind the end of the file."""
    at = 300
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, bits), (259, 3, 1, compression),
               (262, 3, 1, 2 if samples > 2 else 1), (273, 4, strips, at), (277, 3, 1, samples),
               (278, 4, 1, strip_rows or height), (279, 4, strips, 100 if strips == 1 else at)]
    return tiff(entries, b"\0" * at, **rest)


def jbig_tiff():
    """Its own header claims 2^31 pixels a side; the decoder ends a program without the memory."""
    side = 2**31 - 1
    image = struct.pack(">BBBBIIIBBBB", 0, 0, 1, 0, side, side, side, 8, 0, 0, 0)
    at = 8 + 2 + 10 * 12 + 4
    return tiff([(256, 4, 1, 64), (257, 4, 1, 64), (258, 3, 1, 1), (259, 3, 1, 34661),
                 (262, 3, 1, 0), (266, 3, 1, 2), (273, 4, 1, at), (277, 3, 1, 1), (278, 4, 1, 64),
                 (279, 4, 1, len(image))], image)


def padded_tiff(tiles=100, rows=800000):
    """A line of pixels in tiles of many lines, all of which are the same bytes of the file."""
    data = lzma.compress(b"\0" * (rows * 10))
    at = 8 + 2 + 11 * 12 + 4
    lists = struct.pack(f"<{tiles}I", *[at + 8 * tiles] * tiles)
    lists += struct.pack(f"<{tiles}I", *[len(data)] * tiles)
    return tiff([(256, 4, 1, tiles), (257, 4, 1, 1), (258, 3, 1, 16), (259, 3, 1, 34925),
                 (262, 3, 1, 1), (277, 3, 1, 5), (284, 3, 1, 1), (322, 4, 1, 1), (323, 4, 1, rows),
                 (324, 4, tiles, at), (325, 4, tiles, at + 4 * tiles)], lists + data)


def tiled_tiff(width, height, tile):
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 16), (259, 3, 1, 8),
               (262, 3, 1, 2), (277, 3, 1, 3), (322, 4, 1, tile), (323, 4, 1, tile),
               (324, 4, 1, 200), (325, 4, 1, 100)]
    return tiff(entries, zlib.compress(b"\0" * 100000))


def big_tiff(width, height):
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 8), (262, 3, 1, 1),
               (273, 16, 2**40, 16), (278, 4, 1, 1), (279, 16, 2**40, 16)]
    body = struct.pack("<Q", len(entries))
    for tag, kind, count, value in entries:
        body += struct.pack("<HHQQ", tag, kind, count, value)
    return b"II+\0" + struct.pack("<HHQ", 8, 0, 16) + body + struct.pack("<Q", 0)


class Bits:
    """Bits of a byte stream, the lowest first (WebP's lossless format)."""

    def __init__(self):
        self.value, self.count = 0, 0

    def put(self, value, count):
        self.value |= value << self.count
        self.count += count

    def bytes(self):
        return self.value.to_bytes((self.count + 7) // 8, "little")


def webp(width, height):
    """A valid lossless picture of one colour: no bits for a pixel."""
    bits = Bits()
    bits.put(0x2F, 8)
    bits.put(width - 1, 14)
    bits.put(height - 1, 14)
    bits.put(0, 1 + 3)  # no alpha, version 0
    bits.put(0, 1)  # no transform
    bits.put(0, 1)  # no colour cache
    bits.put(0, 1)  # no meta codes
    for _ in range(5):  # a code of one symbol, 0
        bits.put(1, 1)
        bits.put(0, 1)
        bits.put(0, 1)
        bits.put(0, 1)
    data = bits.bytes() + b"\0" * 8
    data += b"\0" * (len(data) % 2)
    chunk = b"WEBPVP8L" + struct.pack("<I", len(data)) + data
    return b"RIFF" + struct.pack("<I", len(chunk)) + chunk


def bmp(width, height, bits=24, compression=0, header=40):
    return (b"BM" + struct.pack("<IHHI", 100, 0, 0, 54)
            + struct.pack("<IiiHHIIiiII", header, width, height, 1, bits, compression, 0, 0, 0, 0, 0)
            + b"\0" * 100)


def claims(make, kind):
    """Headers of all kinds of sizes, from one that is allowed to one that overflows 32 bits."""
    sizes = [(10000, 10000), (65535, 65535), (2**31 - 1, 2**31 - 1), (2**31 - 1, 1), (1, 2**31 - 1),
             (0, 10), (46341, 46341), (100000, 1000)]
    return {f"{kind}-{w}x{h}": make(w, h) for w, h in sizes}


def hostile():
    files = {}
    files |= {f"{k}.png": v for k, v in claims(png, "plain").items()}
    files |= {f"{k}.png": v for k, v in claims(lambda w, h: png(w, h, 16, 6, 1), "deep").items()}
    files |= {f"{k}.tif": v for k, v in claims(tiff_picture, "strip").items()}
    files |= {f"{k}.bmp": v for k, v in claims(bmp, "plain").items()}
    for magic in ("P2", "P3", "P5", "P6"):
        files |= {f"{k}.ppm": v for k, v in claims(
            lambda w, h, m=magic: f"{m} {w} {h} 65535\n1 2 3".encode(), magic).items()}
    for kind in (0xC0, 0xC2, 0xC9, 0xCA):
        for w, h in ((65535, 65535), (10000, 10000), (65500, 1500), (2000, 2000)):
            files[f"{kind:x}-{w}x{h}.jpg"] = jpeg(w, h, kind)
    files["scans.jpg"] = jpeg(2000, 2000, 0xC2, 60)
    for w, h in ((16384, 16384), (10000, 10000), (16384, 6000), (2000, 2000)):
        files[f"solid-{w}x{h}.webp"] = webp(w, h)
    return files | special_pngs() | special_tiffs() | others()


def special_pngs():
    text = png_chunk(b"zTXt", b"Comment\0\0" + zlib.compress(zlib.compress(b"\0" * (1 << 20), 9), 9))
    profile = png_chunk(b"iCCP", b"p\0\0" + bomb(1))
    return {
        "bomb.png": png(10000, 10000, data=bomb(1)),
        "bomb-1bit.png": png(10000, 10000, 1, data=bomb(1)),
        "bomb-2000.png": png(2000, 2000, 16, 6, 1, data=bomb(1)),
        "text.png": png(100, 100, data=bomb(1), before=text * 10),
        "profile.png": png(100, 100, data=bomb(1), before=profile),
        "palette.png": png(2000, 2000, 8, 3, before=png_chunk(b"PLTE", b"\0" * 3), data=bomb(1)),
        "chunk.png": b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 2**31 - 1) + b"IHDR",
    }


def special_tiffs():
    return {
        "loop.tif": tiff_picture(2000, 2000, next_directory=8),
        "strips.tif": tiff_picture(1000, 90000, strip_rows=1, strips=90000),
        "many-strips.tif": tiff_picture(1000, 90000, strip_rows=1, strips=2**31 - 1),
        "many-values.tif": tiff([(256, 4, 2**31 - 1, 8), (257, 4, 2**31 - 1, 8)]),
        "profile.tif": tiff([(256, 4, 1, 10), (257, 4, 1, 10), (34675, 7, 2**30, 8)]),
        "jbig.tif": jbig_tiff(),
        "padded.tif": padded_tiff(),
        "tile.tif": tiled_tiff(2000, 2000, 65520),
        "tile-2000.tif": tiled_tiff(2000, 2000, 2000),
        "deep-strip.tif": tiff_picture(2000, 2000, 16, 5, 8),
        "fax.tif": tiff_picture(10000, 10000, 1, 1, 4),
        "jpeg.tif": tiff_picture(10000, 10000, 8, 1, 7),
        "zstd.tif": tiff_picture(10000, 10000, 8, 1, 50000),
        "big.tif": big_tiff(10000, 10000),
        "entries.tif": b"II*\0" + struct.pack("<IH", 8, 65535) + b"\0" * 900,
        "motorola.tif": b"MM\0*" + struct.pack(">IH", 8, 65535) + b"\xff" * 900,
    }


def others():
    return {
        "empty.png": b"", "one.png": b"\x89", "binary.png": bytes(range(256)) * 4,
        "gif.png": b"GIF89a" + b"\xff" * 100, "pbm.png": b"P4 65535 65535\n",
        "negative.bmp": bmp(10000, -10000), "min.bmp": bmp(-2**31, -2**31),
        "bits.bmp": bmp(10, 10, 65535), "rle.bmp": bmp(10000, 10000, 8, 1),
        "comment.ppm": b"P5 #" + b"c" * 1000, "digits.ppm": b"P5 " + b"9" * 900,
        "riff.webp": b"RIFF\xff\xff\xff\xffWEBPVP8X" + b"\xff" * 100,
        "lossy.webp": b"RIFF\x20\0\0\0WEBPVP8 \x14\0\0\0\x30\x01\0\x9d\x01\x2a\xff\x3f\xff\x3f"
                      + b"\0" * 10,
    }
