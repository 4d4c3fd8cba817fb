#pragma once

#include <string>
#include <vector>

// Files of cameras as other programs write them: small examples, written from the formats'
// documentation for these tests.

namespace tagcal {

inline const std::string kOpenCVYaml =
    "%YAML:1.0\n---\ncalibration_time: \"Tue Mar  3 10:00:00 2026\"\nnframes: 2\n"
    "image_width: 640\nimage_height: 480\nboard_width: 9\nboard_height: 6\n"
    "square_size: 2.5000000372529030e-02\nflags: 0\n"
    "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 5.3591573396000001e+02, 0., 3.4228315473000001e+02, 0.,\n"
    "       5.3591573396000001e+02, 2.3557082909000001e+02, 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
    "   data: [ -2.6637260909660682e-01, -3.8588898922304653e-02,\n"
    "       1.7831947042852964e-03, -2.8122100441115472e-04, 2.3839153080878486e-01 ]\n"
    "avg_reprojection_error: 3.9259109139114490e-01\n"
    "extrinsic_parameters: !!opencv-matrix\n   rows: 2\n   cols: 6\n   dt: d\n"
    "   data: [ 1.6866e-01, 2.7567e-01, 1.3463e-02, -7.5217e-02, -1.0895e-01, 3.9970e-01,\n"
    "       4.1331e-01, 6.4934e-01, -1.3371e+00, -5.9070e-02, 8.2628e-02, 3.5059e-01 ]\n";

inline const std::string kOpenCVXml =
    "<?xml version=\"1.0\"?>\n<opencv_storage>\n<calibration_Time>\"today\"</calibration_Time>\n"
    "<image_width>640</image_width>\n<image_height>480</image_height>\n"
    "<!-- flags: +fix_aspectRatio -->\n"
    "<camera_matrix type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n"
    "  <dt>d</dt>\n  <data>\n    6.0012345678901234e+02 0. 3.1950000000000000e+02 0.\n"
    "    6.0100000000000000e+02 2.3950000000000000e+02 0. 0. 1.</data></camera_matrix>\n"
    "<distortion_coefficients type_id=\"opencv-matrix\">\n  <rows>5</rows>\n  <cols>1</cols>\n"
    "  <dt>d</dt>\n  <data>\n    -4.1e-01 5.2e-01 0. 0. -5.8e-01</data>"
    "</distortion_coefficients>\n</opencv_storage>\n";

inline const std::string kOpenCVJson =
    "{\n    \"image_width\": 640,\n    \"image_height\": 480,\n    \"camera_matrix\": {\n"
    "        \"type_id\": \"opencv-matrix\",\n        \"rows\": 3,\n        \"cols\": 3,\n"
    "        \"dt\": \"d\",\n        \"data\": [ 6.0012345678901234e+02, 0.0, 319.5, 0.0, 601.0,\n"
    "            239.5, 0.0, 0.0, 1.0 ]\n    },\n    \"distortion_coefficients\": {\n"
    "        \"type_id\": \"opencv-matrix\",\n        \"rows\": 1,\n        \"cols\": 12,\n"
    "        \"dt\": \"d\",\n        \"data\": [ -0.41, 0.52, 0.0, 0.0, -0.58, 0.0, 0.0, 0.0,\n"
    "            0.0, 0.0, 0.0, 0.0 ]\n    }\n}\n";

inline const std::string kStereoYaml =
    "%YAML:1.0\n---\n"
    "M1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 534., 0., 341., 0., 534., 232., 0., 0., 1. ]\n"
    "D1: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -0.28, 0.09, 0., 0., 0. ]\n"
    "M2: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 538., 0., 326., 0., 538., 248., 0., 0., 1. ]\n"
    "D2: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -0.29, 0.11, 0., 0., 0. ]\n";

inline const std::string kKalibr =
    "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n"
    "  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n"
    "  distortion_model: radtan\n  intrinsics: [458.654, 457.296, 367.215, 248.375]\n"
    "  resolution: [752, 480]\n  rostopic: /cam0/image_raw\n"
    "cam1:\n  T_cn_cnm1:\n"
    "  - [0.9999971, 0.0023171, 0.0003939, -0.1100738]\n"
    "  - [-0.0023120, 0.9998980, 0.0140902, 0.0003991]\n"
    "  - [-0.0004265, -0.0140890, 0.9999007, -0.0008537]\n"
    "  - [0.0, 0.0, 0.0, 1.0]\n"
    "  cam_overlaps: [0]\n  camera_model: pinhole\n"
    "  distortion_coeffs: [-0.013, 0.02, -0.01, 0.001]\n  distortion_model: equidistant\n"
    "  intrinsics: [457.587, 456.134, 379.999, 255.238]\n  resolution: [752, 480]\n"
    "  rostopic: /cam1/image_raw\n";

inline const std::string kKalibrSphere =
    "cam0:\n  camera_model: ds\n  intrinsics: [-0.17, 0.59, 158.3, 158.4, 254.9, 256.9]\n"
    "  distortion_model: none\n  distortion_coeffs: []\n  resolution: [512, 512]\n"
    "  rostopic: /a\n";

inline const std::string kEuroc =
    "sensor_type: camera\ncomment: VI-Sensor cam0 (MT9M034)\n\nT_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [0.0, -1.0, 0.0, -0.02,\n         1.0, 0.0, 0.0, -0.06,\n"
    "         0.0, 0.0, 1.0, 0.01,\n         0.0, 0.0, 0.0, 1.0]\n\nrate_hz: 20\n"
    "resolution: [752, 480]\ncamera_model: pinhole\n"
    "intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv\n"
    "distortion_model: radial-tangential\n"
    "distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n";

inline const std::string kRosYaml =
    "image_width: 640\nimage_height: 480\ncamera_name: front\ncamera_matrix:\n  rows: 3\n"
    "  cols: 3\n  data: [600.5, 0.0, 320.25, 0.0, 601.0, 240.0, 0.0, 0.0, 1.0]\n"
    "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n"
    "  data: [-0.2, 0.05, 0.001, 0.002, 0.0]\nrectification_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\nprojection_matrix:\n  rows: 3\n"
    "  cols: 4\n  data: [550.0, 0.0, 321.0, 0.0, 0.0, 580.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\n";

inline const std::string kColmap =
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n# Number of cameras: 3\n"
    "1 OPENCV 640 480 600 601 320.5 240.5 -0.2 0.05 0.001 -0.002\n"
    "2 SIMPLE_RADIAL 1024 768 900.25 512 384 0.03\n"
    "7 OPENCV_FISHEYE 512 512 190.1 190.2 255 256.5 0.003 0.0007 -0.002 0.0002\n";

inline const std::string kColmapImages =
    "# Image list with two lines of data per image:\n"
    "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "1 0.5 0.5 -0.5 0.5 0.1 -0.2 3 1 left01.png\n"
    "2362.39 248.498 58396 1784.7 268.254 -1\n"
    "2 1 0 0 0 0 0 1 7 right01.png\n\n";

inline const std::string kMrcal =
    "# generated on 2026-03-03 with   mrcal-calibrate-cameras --lensmodel 'LENSMODEL_OPENCV8'\n"
    "{\n    'lensmodel':  'LENSMODEL_OPENCV8',\n\n"
    "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
    "    'intrinsics': [ 1190.6, 1190.1, 804.3, 455.2, 0.03, -0.15, 0, 0, 0.11, -0.01, 0.01, 0,],\n"
    "\n    'valid_intrinsics_region': [\n    [ 0, 0 ],\n    [ 1599, 0 ],\n    [ 1599, 895 "
    "],\n],\n\n"
    "    # extrinsics are rt_fromref\n"
    "    'extrinsics': [ 0.1, -0.2, 0.3, 1, 2, -0.5,],\n\n    'imagersize': [ 1600, 896,],\n\n"
    "    'icam_intrinsics': 0,\n\n    # it's in base 85\n"
    "    'optimization_inputs': b'P)h>@6aWAK{2mk:,]}#%&\"-<x`y~^|?!',\n\n}\n";

inline const std::string kNerfstudio =
    "{\n\t\"w\": 640,\n\t\"h\": 480,\n\t\"fl_x\": 600.0,\n\t\"fl_y\": 601.0,\n\t\"cx\": 320.5,\n"
    "\t\"cy\": 240.5,\n\t\"k1\": -0.2,\n\t\"k2\": 0.05,\n\t\"p1\": 0,\n\t\"p2\": 1e-05,\n"
    "\t\"camera_model\": \"OPENCV\",\n\t\"frames\": [\n\t\t{\n"
    "\t\t\t\"file_path\": \"images/frame_00001.png\",\n\t\t\t\"transform_matrix\": [\n"
    "\t\t\t\t[1.0, 0.0, 0.0, 1.0],\n\t\t\t\t[0.0, 0.0, -1.0, -2.0],\n"
    "\t\t\t\t[0.0, 1.0, 0.0, 0.5],\n\t\t\t\t[0.0, 0.0, 0.0, 1.0]\n\t\t\t],\n"
    "\t\t\t\"colmap_im_id\": 1\n\t\t}\n\t]\n}\n";

inline const std::string kInstantNgp =
    "{\"camera_angle_x\":1.2,\"w\":800,\"h\":600,\"frames\":[{\"file_path\":\"a/0\","
    "\"transform_matrix\":[[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}]}";

inline const std::string kBasalt =
    "{\n    \"value0\": {\n        \"T_imu_cam\": [\n            {\"px\": 0.05, \"py\": -0.01,\n"
    "             \"pz\": 0.02, \"qx\": 0.5, \"qy\": -0.5, \"qz\": 0.5, \"qw\": 0.5},\n"
    "            {\"px\": 0, \"py\": 0, \"pz\": 0, \"qx\": 0, \"qy\": 0, \"qz\": 0, \"qw\": 1},\n"
    "            {\"px\": 0, \"py\": 0, \"pz\": 0, \"qx\": 0, \"qy\": 0, \"qz\": 0, \"qw\": 1}\n"
    "        ],\n        \"intrinsics\": [\n"
    "            {\"camera_type\": \"kb4\", \"intrinsics\": {\"fx\": 190.9, \"fy\": 190.8,\n"
    "             \"cx\": 254.9, \"cy\": 256.8, \"k1\": 0.0034, \"k2\": 0.00071, \"k3\": -0.002,\n"
    "             \"k4\": 0.0002}},\n"
    "            {\"camera_type\": \"ds\", \"intrinsics\": {\"fx\": 158.3, \"fy\": 158.3,\n"
    "             \"cx\": 254.9, \"cy\": 256.9, \"xi\": -0.17, \"alpha\": 0.59}},\n"
    "            {\"camera_type\": \"pinhole-radtan8\", \"intrinsics\": {\"fx\": 269.7,\n"
    "             \"fy\": 269.8, \"cx\": 322.6, \"cy\": 228.9, \"k1\": 0.302, \"k2\": -0.021,\n"
    "             \"p1\": -0.00025, \"p2\": 6.1e-05, \"k3\": 0.0158, \"k4\": 0.575,\n"
    "             \"k5\": -0.063, \"k6\": 0.034, \"rpmax\": 2.7276}}\n        ],\n"
    "        \"resolution\": [[512, 512], [512, 512], [640, 480]],\n"
    "        \"calib_accel_bias\": [0,0,0,0,0,0,0,0,0],\n        \"vignette\": []\n    }\n}\n";

inline const std::string kTruthYaml =
    "camera:\n  image_width: 640\n  image_height: 480\n  model: \"radial1\"\n  fx: 500\n  fy: 500\n"
    "  cx: 321\n  cy: 239\n  distortion: [-0.1, 0, 0, 0, 0]\nposes:\n"
    "  - {image: \"000.png\", camera_from_world: {rotation: [1, 0, 0, 0], translation_m: [0, 0, "
    "2]}}\n";

}  // namespace tagcal
