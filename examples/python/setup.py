"""Compiles the library that pktrt.py loads, by pktrt.py itself, with CC and CFLAGS of the environment."""
import os
import pathlib
import re
import shutil
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = pathlib.Path(__file__).resolve().parent
HEADER = HERE / "pktrt.h" if (HERE / "pktrt.h").exists() else HERE.parents[1] / "pktrt.h"


class Compile(build_ext):
    def build_extension(self, ext):
        os.environ["PKTRT_HEADER"] = str(HEADER)
        os.environ.setdefault("PKTRT_CACHE", str(pathlib.Path(self.build_temp).resolve()))
        sys.path.insert(0, str(HERE))
        import pktrt  # compiles
        made = pathlib.Path(self.get_ext_fullpath(ext.name))
        made.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(pktrt.library_path, made)


version = int(re.search(r"#define PKTRT_VERSION (\d+)", HEADER.read_text()).group(1))
setup(version=f"{version // 10000}.{version // 100 % 100}.{version % 100}", cmdclass={"build_ext": Compile},
      ext_modules=[Extension("_pktrt", sources=[])])
