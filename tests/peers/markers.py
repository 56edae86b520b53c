"""Writes OpenCV's ArUco dictionaries, and a board as OpenCV draws it, where carom reads them; `--check` compares in place of writing."""

import pathlib
import sys

import cv2
import numpy as np

ROOT = pathlib.Path(__file__).parent.parent.parent
ACROSS = 20  # codes a line
HEAD = "# Codes of OpenCV's ArUco dictionaries DICT_<n>X<n>_1000, of which the smaller ones are the first 50, 100 and 250, and of its\n\
# DICT_APRILTAG_<family>: n or the family, then the markers' bits (white is 1) from the upper left, row by row, as hexadecimal numbers.\n\
# Written by tests/peers/markers.py.\n"
FAMILIES = {"16h5": 4, "25h9": 5, "36h10": 6, "36h11": 6}


def codes(name, size):
    book = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))
    for number in range(len(book.bytesList)):
        bits = cv2.aruco.Dictionary.getBitsFromByteList(book.bytesList[number : number + 1], size).flatten()
        yield "%x" % int("".join(str(bit) for bit in bits), 2)


def lines(name, every):
    return f"{name}\n" + "".join(" ".join(every[k : k + ACROSS]) + "\n" for k in range(0, len(every), ACROSS))


def dictionaries():
    text = HEAD
    for size in (4, 5, 6, 7):
        for smaller in (50, 100, 250):
            least = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{size}X{size}_{smaller}")).bytesList
            most = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{size}X{size}_1000")).bytesList
            assert np.array_equal(least, most[:smaller])
        text += lines(size, list(codes(f"{size}X{size}_1000", size)))
    for family, size in FAMILIES.items():
        text += lines(family, list(codes(f"APRILTAG_{family}", size)))
    return text.encode()


def board():
    """5 × 7 squares of 40 px, markers of 30 px, without a margin."""
    book = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    drawn = cv2.aruco.CharucoBoard((5, 7), 0.04, 0.028, book).generateImage((200, 280))
    return cv2.imencode(".png", drawn, [cv2.IMWRITE_PNG_BILEVEL, 1, cv2.IMWRITE_PNG_COMPRESSION, 9])[1].tobytes()


for name, data in {"stages/track/src/board/dictionaries.txt": dictionaries(), "stages/track/tests/board.png": board()}.items():
    path = ROOT / name
    if "--check" not in sys.argv:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)
    elif path.read_bytes() != data:
        sys.exit(f"failed to check {name}: OpenCV {cv2.__version__} has others; write it again")
