"""Pictures and maps from camera to camera, panorama and plane; OpenCV as a witness."""

import cv2
import numpy as np
import pytest
import tagcal

SIZE = (160, 120)
CAMERA = tagcal.Camera.perspective(130, 131, 80.2, 58.9, SIZE, [-0.12, 0.03, 0.001, -0.002])
PINHOLE = tagcal.Camera.pinhole(120, 121, 79, 60, SIZE)
WIDE = tagcal.Camera.fisheye(60, 60, 79.5, 59.5, SIZE, [0.01])


def picture(dtype: type = np.uint8, colour: bool = False) -> np.ndarray:
    y, x = np.mgrid[0:120, 0:160]
    grey = 0.5 + 0.2 * np.sin(x / 9) + 0.25 * np.cos(y / 7)
    image = (grey * np.iinfo(dtype).max).astype(dtype)
    return np.stack([image, image[::-1], image[:, ::-1]], axis=2) if colour else image


def test_map_is_that_of_opencv_and_of_the_projection() -> None:
    x, y = tagcal.pixel_map(CAMERA, PINHOLE)
    assert x.dtype == np.float32 and x.shape == y.shape == (120, 160)
    theirs = cv2.initUndistortRectifyMap(
        CAMERA.matrix, CAMERA.distortion, None, PINHOLE.matrix, SIZE, cv2.CV_32FC1
    )
    np.testing.assert_allclose(x, theirs[0], atol=2e-5)
    np.testing.assert_allclose(y, theirs[1], atol=2e-5)
    pixel = CAMERA.project(PINHOLE.unproject([30.0, 40.0]))
    np.testing.assert_allclose([x[40, 30], y[40, 30]], pixel, atol=2e-5)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("colour", [False, True])
def test_pictures_are_those_of_cv2_remap(dtype: type, colour: bool) -> None:
    image = picture(dtype, colour)
    maps = tagcal.pixel_map(CAMERA, PINHOLE)
    new, seen = tagcal.reproject(image, CAMERA, PINHOLE, area_correct=False)
    assert new.dtype == dtype and new.shape == image.shape
    assert seen.dtype == np.uint8 and seen.shape == (120, 160)
    assert set(np.unique(seen)) <= {0, 255}
    theirs = cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inside = seen == 255
    difference = np.abs(new.astype(float) - theirs)[inside] / np.iinfo(dtype).max
    assert inside.mean() > 0.9 and difference.max() < 0.005  # cv2 has 1/32 px
    again, seen_again = tagcal.remap(image, *maps, area_correct=False)
    np.testing.assert_array_equal(seen, seen_again)
    assert np.abs(again.astype(float) - new).max() <= 1


def test_same_as_cv2_undistort() -> None:
    target = tagcal.Camera.from_matrix(CAMERA.matrix, SIZE)
    new, seen = tagcal.reproject(picture(), CAMERA, target, area_correct=False)
    theirs = cv2.undistort(picture(), CAMERA.matrix, CAMERA.distortion)
    inner = (slice(10, -10), slice(10, -10))
    assert seen[inner].min() == 255
    assert np.abs(new[inner].astype(int) - theirs[inner]).max() <= 2


def test_the_same_camera_gives_the_same_picture_for_every_layout() -> None:
    for image in (picture(), picture(np.uint16), picture(colour=True), picture(np.uint16, True)):
        wide = np.zeros((120, 200) + image.shape[2:], image.dtype)
        wide[:, 20:180] = image
        read_only = image.copy()
        read_only.flags.writeable = False
        for layout in (image, wide[:, 20:180], np.asfortranarray(image), read_only):
            new, seen = tagcal.reproject(layout, PINHOLE, PINHOLE, interpolation="nearest")
            np.testing.assert_array_equal(new, image)
            assert seen.min() == 255
    flipped = picture(colour=True)[:, :, ::-1]
    new, _ = tagcal.reproject(flipped, PINHOLE, PINHOLE, interpolation="nearest")
    np.testing.assert_array_equal(new, flipped)


def test_threads_border_and_rotation() -> None:
    turn = tagcal.Pose([np.cos(0.2), 0, np.sin(0.2), 0], [0, 0, 0])
    image = picture(colour=True)
    one, seen = tagcal.reproject(image, CAMERA, PINHOLE, turn, border=(1, 2, 3))
    two, _ = tagcal.reproject(image, CAMERA, PINHOLE, turn, border=(1, 2, 3), threads=2)
    np.testing.assert_array_equal(one, two)
    assert 0 < (seen == 0).mean() < 1
    assert (one[seen == 0] == (1, 2, 3)).all()
    x, _ = tagcal.pixel_map(CAMERA, PINHOLE, turn.matrix)
    pixel = CAMERA.project(turn.matrix[:3, :3] @ PINHOLE.unproject([20.0, 60.0]))
    assert x[60, 20] == pytest.approx(pixel[0], abs=1e-4)
    assert tagcal.reproject(picture(), CAMERA, PINHOLE, turn, border=7)[0][seen == 0].max() == 7


def test_plane() -> None:
    plane = tagcal.PlaneRaster([-0.1, 0.08], 0.002, (100, 80))
    pose = tagcal.Pose([0, 1, 0.1, 0], [0.01, 0.02, 0.4])
    x, y = tagcal.pixel_map(CAMERA, plane, pose)
    point = [-0.1 + 0.002 * 30, 0.08 - 0.002 * 50, 0]
    np.testing.assert_allclose([x[50, 30], y[50, 30]], CAMERA.project(point, pose), atol=1e-4)
    assert tagcal.reproject(picture(), CAMERA, plane, pose)[0].shape == (80, 100)
    with pytest.raises(tagcal.Error, match="camera_from_target: must be the pose of the plane"):
        tagcal.pixel_map(CAMERA, plane)
    assert repr(plane) == "<PlaneRaster 100 x 80, 0.002 m per pixel>"


@pytest.mark.parametrize("kind", ["equirectangular", "cylindrical"])
def test_panorama(kind: str) -> None:
    panorama = tagcal.panorama_of(WIDE, kind)
    assert panorama.kind == kind and panorama.px_per_rad == 60
    x, y = tagcal.pixel_map(WIDE, panorama)
    longitude = (40 - panorama.centre[0]) / 60
    down = (50 - panorama.centre[1]) / 60
    height = np.tan(down) if kind == "equirectangular" else down
    direction = [np.sin(longitude), height, np.cos(longitude)]
    np.testing.assert_allclose([x[50, 40], y[50, 40]], WIDE.project(direction), atol=1e-3)
    same = tagcal.Panorama(kind, panorama.px_per_rad, panorama.centre, panorama.size)
    assert same.to_dict() == panorama.to_dict()


def test_pinholes() -> None:
    everything = tagcal.pinhole_of_all_pixels(CAMERA)
    valid = tagcal.pinhole_of_valid_pixels(CAMERA)
    assert everything.size == valid.size == SIZE
    assert everything.matrix[0, 0] < valid.matrix[0, 0]
    assert (tagcal.reproject(picture(), CAMERA, valid)[1] == 255).all()
    corners = np.array([[0.0, 0], [159, 0], [0, 119], [159, 119]])
    inside = everything.project(CAMERA.unproject(corners))
    assert (inside >= -0.5).all() and (inside <= [159.5, 119.5]).all()
    given = tagcal.pinhole_of_focal_length(CAMERA, 65, (80, 60))
    assert given.size == (80, 60) and given.matrix[0, 0] == 65
    assert given.matrix[1, 1] == pytest.approx(65 * 131 / 130)


def test_several_pinholes_and_range() -> None:
    cube = tagcal.several_pinholes(WIDE, 5)
    assert [face.name for face in cube] == ["front", "left", "right", "up", "down"]
    left = cube[1].camera_from_turned
    np.testing.assert_allclose(left.matrix[:3, :3] @ [0, 0, 1], [-1, 0, 0], atol=1e-12)
    image, seen = tagcal.reproject(picture(), WIDE, cube[1].camera, left)
    assert image.shape == (cube[1].camera.size[1], cube[1].camera.size[0]) and seen.max() == 255
    whole = tagcal.angular_range(PINHOLE)
    assert whole.right_rad == pytest.approx(np.arctan(80.5 / 120))
    assert repr(whole).startswith("<AngularRange 67.")


GREY = picture()
PARALLEL = tagcal.Camera.parallel(9, 9, 5, 5, SIZE)
HUGE = tagcal.Camera.pinhole(100, 100, 0, 0, (20000, 20000))
MAPS = tagcal.pixel_map(CAMERA, PINHOLE)
reproject = tagcal.reproject


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tagcal.pixel_map(CAMERA, HUGE), "target: must have at most 100000000 pixels"),
        (lambda: reproject(GREY, CAMERA, HUGE), "target: must have at most 100000000 pixels"),
        (lambda: tagcal.pinhole_of_all_pixels(HUGE), "camera: must have at most 100000000 pixels"),
        (lambda: reproject(GREY[:50], CAMERA, PINHOLE), "image: must have the camera's size"),
        (lambda: reproject(GREY / 255, CAMERA, PINHOLE), "image: must be uint8 or uint16"),
        (lambda: reproject(None, CAMERA, PINHOLE), "image: must be an array, got None"),
        (lambda: reproject(GREY, CAMERA, PINHOLE, None, "cubic"), 'interpolation: .*"cubic"'),
        (lambda: reproject(GREY, CAMERA, PINHOLE, border=256), "border: .*0 to 255, got 256"),
        (lambda: reproject(GREY, CAMERA, PINHOLE, border=[1, 2, 3]), "border: must be one"),
        (lambda: reproject(GREY, CAMERA, PINHOLE, threads=-1), "threads: must be >= 0"),
        (lambda: tagcal.remap(GREY, MAPS[0], MAPS[1][:5]), "map_y: must have the shape of map_x"),
        (lambda: tagcal.remap(GREY, MAPS[0], "a"), "map_y: must be an array"),
        (lambda: tagcal.panorama_of(CAMERA, "flat"), 'kind: must be .*"flat"'),
        (lambda: tagcal.panorama_of(CAMERA, px_per_rad=-1), "px_per_rad: must be > 0"),
        (lambda: tagcal.Panorama("cylindrical", 1, [0, np.nan], SIZE), "centre: must be finite"),
        (lambda: tagcal.PlaneRaster([0, 0], 0, SIZE), "m_per_px: must be > 0, got 0"),
        (lambda: tagcal.several_pinholes(WIDE, 1), "count: must be 2 to 360, got 1"),
        (lambda: tagcal.pinhole_of_focal_length(WIDE, np.nan), "focal_px: must be > 0"),
        (lambda: tagcal.pinhole_of_all_pixels(PARALLEL), "parallel"),
    ],
)
def test_wrong_arguments(call: object, message: str) -> None:
    with pytest.raises(tagcal.Error, match=message):
        call()  # type: ignore[operator]


def test_map_without_a_source_gives_the_border() -> None:
    x, y = (m.copy() for m in MAPS)
    x[0, :6] = [np.nan, np.inf, -np.inf, 1e30, -1e30, -1]
    image, seen = tagcal.remap(GREY, x, y, border=9)
    assert (seen[0, :6] == 0).all() and (image[0, :6] == 9).all()
