"""A wheel for this platform, with compiled kernels, where MESHOPT_BUILD_KERNELS=1 asks for it."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "MESHOPT_BUILD_KERNELS"
# What the kernels are built for, and tried on.
PLATFORM = ("Linux", "x86_64")


class KernelHook(BuildHookInterface):
    """Does nothing unless it is asked to: then the wheel is for one platform, and any Python."""

    _folder = ""

    def _is_asked(self) -> bool:
        return os.environ.get(VARIABLE, "0") not in ("", "0")

    def dependencies(self) -> list[str]:
        """Compiling needs what running does."""
        return list(self.metadata.core.dependencies) if self._is_asked() else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the kernels, and tell the wheel of them."""
        if version != "standard" or not self._is_asked():
            return
        if (platform.system(), platform.machine()) != PLATFORM:
            sys.exit(f"{VARIABLE}: kernels are built for {' '.join(PLATFORM)} only")
        self._folder = tempfile.mkdtemp(prefix="meshopt-building-")
        script = Path(self.root, "building", "kernels.py")
        subprocess.run([sys.executable, str(script), self._folder], check=True)
        for made in Path(self._folder).iterdir():
            build_data["force_include"][str(made)] = f"meshopt_cli/compiled/{made.name}"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{sysconfig.get_platform().replace('-', '_')}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what the wheel has taken in."""
        if self._folder:
            shutil.rmtree(self._folder)
