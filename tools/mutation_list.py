"""The list of deliberate mistakes, tests/mutations.txt, and what each entry must be."""

import collections
import hashlib

KEYS = ("id", "layer", "kind", "file", "line", "with", "why")
OPTIONAL_KEYS = ("test", "equivalent")
LAYERS = ("geometry", "solvers", "camera", "viewing", "scene", "reproject", "estimate", "detect",
          "io", "validate", "tools", "python")
LEAST_MISTAKES = 80


class Mistake:
  """An entry of the list."""

  def __init__(self, text, number):
    self.fields, self.number = {}, number
    for line in text.splitlines():
      key, colon, value = line.partition(": ")
      if not colon or key not in KEYS + OPTIONAL_KEYS or key in self.fields:
        raise ValueError(f"line {number}: '{line}': must be a key of the list, ': ' and a value")
      self.fields[key] = value
    missing = [key for key in KEYS if key not in self.fields]
    if missing:
      raise ValueError(f"line {number}: the entry has no {', '.join(missing)}")

  def __getattr__(self, key):
    return self.fields.get(key)

  @property
  def digest(self):
    text = "\n".join((self.file, self.line, self["with"]))
    return hashlib.sha1(text.encode()).hexdigest()[:12]

  def __getitem__(self, key):
    return self.fields[key]

  def complaint(self, root):
    """Why the entry does not apply to the sources, or None."""
    if self.layer not in LAYERS:
      return f"layer: must be one of {', '.join(LAYERS)}; got {self.layer}"
    path = root / self.file
    if not path.is_file():
      return f"file: {self.file} does not exist"
    count = path.read_text().count(self.line)
    if count != 1:
      return f"line: must occur once in {self.file}, occurs {count} times: {self.line}"
    if self.line == self["with"]:
      return "with: is the text that stands there"
    return None


def read_list(path):
  """The entries; the first lines of the file and lines that begin with # are no entries."""
  mistakes, lines, start = [], [], 0
  for number, line in enumerate(path.read_text().splitlines() + [""], 1):
    if line.startswith("#"):
      continue
    if line:
      start = start if lines else number
      lines.append(line)
    elif lines:
      mistakes.append(Mistake("\n".join(lines), start))
      lines = []
  return mistakes


def check(mistakes, root):
  """What is wrong with the list, as lines."""
  complaints = []
  ids = collections.Counter(mistake.id for mistake in mistakes)
  complaints += [f"{name}: is used {count} times" for name, count in ids.items() if count > 1]
  for mistake in mistakes:
    complaint = mistake.complaint(root)
    if complaint:
      complaints.append(f"{mistake.id}: {complaint}")
  if len(mistakes) < LEAST_MISTAKES:
    complaints.append(f"must have at least {LEAST_MISTAKES} entries, has {len(mistakes)}")
  layers = {mistake.layer for mistake in mistakes}
  complaints += [f"no mistake in the layer {layer}" for layer in LAYERS if layer not in layers]
  return complaints
