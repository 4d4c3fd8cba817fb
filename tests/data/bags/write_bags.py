#!/usr/bin/python3
"""Writes the bags of this folder: those of ROS 1 by Debian's python3-rosbag, those of rosbag2 by
sqlite3. Pixel (x, y) of frame i is p = (7 x + 13 y + 40 i) mod 256; red, green and blue are p, p +
50 and p + 100 mod 256. Frame i has the stamp 1700000000 + 0.1 i s; frames are recorded in the order
2, 0, 1. Run in this folder; packs messages by the program zstd."""
import os
import sqlite3
import struct
import subprocess
import zlib

import rosbag
import rospy
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import String

W, H = 24, 16
ORDER = (2, 0, 1)
START = 1700000000


def p(x, y, i, plus=0):
    return (7 * x + 13 * y + 40 * i + plus) % 256


def rows(i, pixel, pad=b""):
    return b"".join(b"".join(pixel(x, y, i) for x in range(W)) + pad for y in range(H))


def bayer(x, y, _):  # grbg of one colour
    return bytes([((100, 200), (50, 100))[y % 2][x % 2]])


def rgb(x, y, i):
    return bytes([p(x, y, i), p(x, y, i, 50), p(x, y, i, 100)])


# encoding, is_bigendian, step, data
RAW = {
    "/mono8": lambda i: ("mono8", 0, W, rows(i, lambda x, y, k: bytes([p(x, y, k)]))),
    "/rgb8": lambda i: ("rgb8", 0, 3 * W, rows(i, rgb)),
    "/bgr8": lambda i: ("bgr8", 0, 3 * W + 4, rows(i, lambda x, y, k: rgb(x, y, k)[::-1], b"\xff" * 4)),
    "/mono16": lambda i: ("mono16", 1, 2 * W, rows(i, lambda x, y, k: struct.pack(">H", 256 * p(x, y, k)))),
    "/bayer": lambda i: ("bayer_grbg8", 0, W, rows(i, bayer)),
}


def png(i):
    def part(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    body = b"".join(b"\0" + bytes(p(x, y, i) for x in range(W)) for y in range(H))
    return (b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", W, H, 8, 0, 0, 0, 0))
            + part(b"IDAT", zlib.compress(body, 9)) + part(b"IEND", b""))


def write_ros1(name, compression):
    with rosbag.Bag(name, "w", compression=compression, chunk_threshold=4000) as bag:
        for place, i in enumerate(ORDER):
            recorded = rospy.Time(START + 1 + place)
            for topic, picture in RAW.items():
                image = Image(height=H, width=W)
                image.header.stamp = rospy.Time(START, 100000000 * i)
                image.header.frame_id = "camera"
                image.encoding, image.is_bigendian, image.step, image.data = picture(i)
                bag.write(topic, image, recorded)
            packed = CompressedImage(format="png", data=png(i))
            packed.header.stamp = rospy.Time(START, 100000000 * i)
            bag.write("/packed", packed, recorded)
            bag.write("/chatter", String(data="hello"), recorded)


class Cdr:
    """OMG's Common Data Representation, little-endian."""

    def __init__(self):
        self.body = b""

    def whole(self, value):
        self.body += b"\0" * (-len(self.body) % 4) + struct.pack("<I", value)

    def data(self, data):
        self.whole(len(data))
        self.body += data

    def text(self, text):
        self.data(text.encode() + b"\0")

    def header(self, i):
        self.whole(START)
        self.whole(100000000 * i)
        self.text("camera")

    def message(self):
        return b"\0\1\0\0" + self.body


def cdr_image(i, encoding, big, step, data):
    out = Cdr()
    out.header(i)
    out.whole(H)
    out.whole(W)
    out.text(encoding)
    out.body += bytes([big])
    out.whole(step)
    out.data(data)
    return out.message()


def cdr_messages(i):
    for topic, picture in RAW.items():
        yield topic, "sensor_msgs/msg/Image", cdr_image(i, *picture(i))
    out = Cdr()
    out.header(i)
    out.text("png")
    out.data(png(i))
    yield "/packed", "sensor_msgs/msg/CompressedImage", out.message()
    out = Cdr()
    out.text("hello")
    yield "/chatter", "std_msgs/msg/String", out.message()


def zstd(data):
    return subprocess.run(["zstd", "-q", "-c", f"--stream-size={len(data)}"], input=data, check=True,
                          capture_output=True).stdout


def write_db3(name, pack, orders=ORDER):
    if os.path.exists(name):
        os.remove(name)
    database = sqlite3.connect(name)
    database.executescript(  # rosbag2_storage_sqlite3's schema
        "PRAGMA page_size=1024; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER "
        "NOT NULL, data BLOB NOT NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC);")
    ids = {}
    for place, i in enumerate(ORDER):
        if i not in orders:
            continue
        for topic, kind, data in cdr_messages(i):
            if topic not in ids:
                ids[topic] = len(ids) + 1
                database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (ids[topic], topic, kind))
            database.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                             (ids[topic], (START + 1 + place) * 10**9, pack(data)))
    database.commit()
    database.execute("VACUUM")
    database.close()


for compression in ("none", "bz2", "lz4"):
    write_ros1(f"ros1_{compression}.bag", compression)
write_db3("plain.db3", lambda data: data)
write_db3("packed.db3", zstd)
