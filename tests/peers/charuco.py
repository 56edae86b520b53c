"""A ChArUco board that OpenCV draws, seen by a known camera from known places; and what OpenCV makes of those images.

`python charuco.py FOLDER VIEWS` writes view_NN.jpg, table.jpg and rig.toml into the folder and prints truth and result as JSON."""

import json
import pathlib
import sys

import cv2
import numpy as np

WIDTH, HEIGHT = 1280, 720
MATRIX = np.array([[1012.0, 0, 634.2], [0, 1008.5, 366.8], [0, 0, 1]])
LENS = np.array([-0.17, 0.05, 0.0006, -0.0005, 0.0])
COLUMNS, ROWS, SQUARE, MARKER = 5, 7, 0.04, 0.028
DRAWN = 240  # px a square
TIMES = 3  # the square of this many rays a pixel
CORNERS = np.array([[0.50, 0.13], [0.70, 0.13]])  # of the board on the table: upper left, upper right
POSITION = np.array([0.55, 0.02, 1.15])

folder, views = pathlib.Path(sys.argv[1]), int(sys.argv[2])
book = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
board = cv2.aruco.CharucoBoard((COLUMNS, ROWS), SQUARE, MARKER, book)
drawn = board.generateImage((COLUMNS * DRAWN, ROWS * DRAWN))
noise = np.random.default_rng(7)
grid = (np.stack(np.meshgrid(np.arange(WIDTH * TIMES), np.arange(HEIGHT * TIMES)), axis=-1).reshape(-1, 1, 2) + 0.5) / TIMES - 0.5
rays = cv2.undistortPoints(grid, MATRIX, LENS)


def seen(turn, place):
    """The image of the board whose frame (x right, y down, z into it) is turned and placed so before the camera."""
    plane = np.column_stack((turn[:, 0], turn[:, 1], place))
    flat = np.column_stack((rays.reshape(-1, 2), np.ones(len(rays)))) @ np.linalg.inv(plane).T
    at = (flat[:, :2] / flat[:, 2:] / SQUARE * DRAWN - 0.5).astype(np.float32).reshape(HEIGHT * TIMES, WIDTH * TIMES, 2)
    light = cv2.remap(drawn, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=255).astype(np.float32)
    light = cv2.GaussianBlur(cv2.resize(light, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA), (0, 0), 0.6)
    image = 25 + 0.72 * light + noise.normal(0, 2, light.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def write(name, image):
    cv2.imwrite(str(folder / name), cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), [cv2.IMWRITE_JPEG_QUALITY, 92])


def detected(detector, name):
    found, ids, _, _ = detector.detectBoard(cv2.imread(str(folder / name), cv2.IMREAD_GRAYSCALE))
    return board.matchImagePoints(found, ids)


folder.mkdir(parents=True, exist_ok=True)
middle = np.array([COLUMNS, ROWS]) * SQUARE / 2
for number in range(views):
    # Slants all round, the board all over the image.
    round_ = 2.4 * number
    slant = 0.0 if number == 0 else 0.35 + 0.3 * ((0.618 * number) % 1)
    turn = cv2.Rodrigues(slant * np.array([np.cos(round_), np.sin(round_), 0.0]))[0]
    turn = turn @ cv2.Rodrigues(np.array([0, 0, 0.4 * np.sin(1.3 * number)]))[0]
    aside = np.array([0.16 * np.cos(1.9 * number), 0.07 * np.sin(2.7 * number), 0.46 + 0.08 * np.sin(number)])
    write(f"view_{number:02}.jpg", seen(turn, aside - turn @ [*middle, 0]))

# The camera over the table: rows of its axes (right, down, forward) in the table's frame, a little off straight down.
down = cv2.Rodrigues(np.array([0.03, -0.02, 0.01]))[0] @ np.array([[0.0, -1, 0], [-1, 0, 0], [0, 0, -1]])
along = (CORNERS[1] - CORNERS[0]) / np.linalg.norm(CORNERS[1] - CORNERS[0])
axes = np.column_stack(([*along, 0], [along[1], -along[0], 0], [0, 0, -1]))  # of the board, in the table's frame
write("table.jpg", seen(down @ axes, down @ (np.array([*CORNERS[0], 0]) - POSITION)))
(folder / "rig.toml").write_text(
    '[object]\nshape = "cylinder"\nradius = 0.030\nhalf_height = 0.020\nmass = 0.100\n[striker]\ntip = "sphere"\nradius = 0.012\n'
    "[table]\nx = [0.20, 0.90]\ny = [-0.40, 0.40]\n[camera]\nrate = 60.0\nnoise = 0.0007\ncentre = [0.55, 0.0]\n"
    "[robot]\nspeed = [0.4, 1.0]\nangle = [-0.80, 0.80]\nacceleration = 5.0\n"
)

detector = cv2.aruco.CharucoDetector(board)
pairs = [detected(detector, f"view_{number:02}.jpg") for number in range(views)]
objects, images = zip(*pairs)
error, matrix, lens, _, _ = cv2.calibrateCamera(objects, images, (WIDTH, HEIGHT), None, None, flags=cv2.CALIB_FIX_K3)
points, pixels = detected(detector, "table.jpg")
flat = points.reshape(-1, 3)
on_table = np.column_stack((CORNERS[0] + flat[:, :1] * along + flat[:, 1:2] * [along[1], -along[0]], np.zeros(len(flat))))
_, turn, place = cv2.solvePnP(on_table, pixels, matrix, lens)
position = (-cv2.Rodrigues(turn)[0].T @ place).ravel()
print(
    json.dumps(
        {
            # OpenCV gives the rms of a corner's distance; of a coordinate it is less by a factor of √2.
            "error": error / 2**0.5,
            "used": int(sum(len(image) for image in images)),
            "matrix": [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]],
            "distortion": lens.ravel().tolist(),
            "position": position.tolist(),
            "corners": CORNERS.tolist(),
            "truth": {
                "matrix": [MATRIX[0, 0], MATRIX[1, 1], MATRIX[0, 2], MATRIX[1, 2]],
                "distortion": LENS.tolist(),
                "position": POSITION.tolist(),
            },
        }
    )
)
