#!/bin/sh
# The pictures of docs/tasks/python.md. Run in the root of the project, after tools/setup.sh --python:
#   docs/tasks/python/pictures.sh
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
MPLBACKEND=Agg PYTHONPATH=${PYTHONPATH:-build/release/python} \
  /usr/bin/python3 tests/python/page.py docs/tasks/python.md "$work" || echo "the page shows another output, see above" >&2
/usr/bin/python3 - "$work"/*.png <<'END'
import sys
from PIL import Image
for name in sys.argv[1:]:  # 64 colours: a third of the bytes
    picture = Image.open(name)
    picture = picture if picture.mode == "L" else picture.convert("RGB").quantize(64, dither=0)
    picture.save("docs/tasks/python/" + name.rpartition("/")[2], optimize=True)
END
