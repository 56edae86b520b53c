"""`wheel.py WHEEL`: says what is in it, and holds it to what is promised."""

import sys
import tempfile
import zipfile
from pathlib import Path

from promised import check_glibc, check_size

wheel = Path(sys.argv[1])
print(wheel.name)
check_size("wheel", wheel.stat().st_size)
with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(wheel) as packed:
    for name in ["carom/_carom.abi3.so", "carom/bin/strike"]:
        file = Path(packed.extract(name, folder))
        check_size(file.name, file.stat().st_size)
        check_glibc(file)
