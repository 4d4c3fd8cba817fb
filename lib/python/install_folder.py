"""Prints the folder of Python packages below a prefix, relative to it, as sysconfig names it.

    install_folder.py PREFIX

Debian's Python looks into dist-packages of /usr and /usr/local. Other prefixes, such as that of a
virtual environment, have lib/pythonX.Y/site-packages.
"""

import os
import sys
import sysconfig


def package_folder(prefix: str) -> str:
    schemes = sysconfig.get_scheme_names()
    scheme, base = "posix_prefix", prefix
    if prefix == "/usr" and "deb_system" in schemes:
        scheme = "deb_system"
    elif prefix == "/usr/local" and "posix_local" in schemes:
        scheme, base = "posix_local", "/usr"  # the scheme appends /local itself
    folder = sysconfig.get_path("platlib", scheme, vars={"base": base, "platbase": base})
    return os.path.relpath(folder, prefix)


if __name__ == "__main__":
    print(package_folder(os.path.normpath(sys.argv[1])))
