# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
# Made by misc/python/make_stubs.py: do not edit.
"""3D tracking of articulated surgical tools

Finds the pose of articulated tools in the endoscope's camera from video, CAD model and joint readings, although the hand-eye
calibration is wrong by millimetres and degrees. Implements [ye2016realtime], and on top of it (METHOD_FULL, the default)
errors of the joint readings, outlines, a second eye and a verdict on every pose.

Data flows one way through the stages; the correction found in frame t-1 is the only thing that goes back, into the view of
frame t:

    ToolModel ---+                                                                   +-> ToolPoseEKF (METHOD_PAPER) --------+
                 +-> PartTemplateRenderer -> QGOMatcher -> GeometricContextVerifier -+-> solveEPnP() (METHOD_EPNP) ---------+-> estimate
    MeshRenderer +           |                                                       +-> ArticulatedPoseEKF (METHOD_FULL) --+
                             |                                                              |                 ^
                             |                                            pose of the parts |                 | edges on normals
                             |                                                              v                 |
                             +-> ToolContour: outline of the drawing -------------> placeContour() -> matchContour()
    |<------------------------------------------ ToolTracker: all of it, per frame ------------------------------------------->|

METHOD_FULL runs the upper row once for each eye; one filter takes in the points and edges of all of them. Beside the pose it
reports evidence that the filter does not have: how similar the parts are, and how much of the outline is where it should be.

**Frames.** `base`: the arm's remote centre of motion. `tool`: the end effector of the tool file. `nominal`: where the hand-eye
calibration believes the camera is. `camera`: x right, y down, z forward. `a_T_b` maps coordinates in b to coordinates in a:

    camera_T_tool = camera_T_nominal * nominal_T_base * base_T_tool(joints)

and `camera_T_nominal`, the correction, is what is sought. METHOD_FULL seeks the joints' errors as well: there `joints` are the
readings plus ToolEstimate.jointOffsets. With a right camera all poses are in the frame of the left one.

**Units.** Metres, radians, seconds, pixels. Pixel (0, 0) is the centre of the top-left pixel.

**Headers.** `opencv2/surgtrack.hpp` is tracking. `opencv2/surgtrack/lab.hpp` is what is around it: synthetic scenes, hand-eye
calibration, time offsets, importers, live data, the scene from outside and scores against the truth."""

from typing import Any, Optional, Sequence as _Sequence, Tuple, Union, overload

import numpy as np
from numpy.typing import NDArray

ToolModel_JOINT_FIXED: int
ToolModel_JOINT_REVOLUTE: int
ToolModel_JOINT_PRISMATIC: int
STATE_INITIALIZING: int
"""no confirmed pose yet: that of the kinematics, or a first measurement"""
STATE_TRACKING: int
"""the pose was measured in this frame"""
STATE_COASTING: int
"""nothing was measured for a short while: kinematics with the last correction; or, with METHOD_FULL, the tool was found elsewhere, which further frames are to confirm"""
STATE_LOST: int
"""the pose must not be used"""
METHOD_PAPER: int
"""[ye2016realtime] as published: six-state filter on the hand-eye correction"""
METHOD_EPNP: int
"""the paper's baseline: EPnP on the matches of each frame alone"""
METHOD_FULL: int
"""beyond the paper: joint offsets, outlines, both eyes, pushes of the camera, and evidence from parts and outline"""
LAYOUT_SEPARATE: int
"""`separate`, or no key: a file each"""
LAYOUT_SIDE_BY_SIDE: int
"""`side_by_side`: in one file, the left eye's image left of the right one's"""
LAYOUT_TOP_BOTTOM: int
"""`top_bottom`: in one file, the left eye's image above the right one's"""
HAND_EYE_BOARD_ON_TOOL: int
"""the instrument holds the board, the camera stands: mount = the arm's base, holder = the tool"""
HAND_EYE_CAMERA_ON_ARM: int
"""an arm holds the camera, the board lies: mount = the end of that arm, holder = its base"""
HAND_EYE_BEST: int
"""that with the smallest error in poses left out"""
HAND_EYE_TSAI: int
"""Tsai and Lenz 1989, as in the paper"""
HAND_EYE_PARK: int
HAND_EYE_HORAUD: int
HAND_EYE_ANDREFF: int
HAND_EYE_DANIILIDIS: int
HAND_EYE_SHAH: int
HAND_EYE_LI: int
HAND_EYE_REFINED: int
"""least squares of the poses' errors in their standard deviations, from the best of the others"""
CalibrationBoard_CHESSBOARD: int
CalibrationBoard_ASYMMETRIC_CIRCLES: int
JOINTS_FOUND: int
"""readings before and after the time, or at it"""
JOINTS_NONE: int
"""a coordinate has no reading at all"""
JOINTS_TOO_OLD: int
"""the time lies before the history"""
JOINTS_TOO_NEW: int
"""the time lies after the last reading: wait for the next one"""
JOINTS_GAP: int
"""the readings before and after are too far apart"""

class CameraModel:
    """A calibrated camera: intrinsics, lens distortion and image size.

    Everything in the module works in the image as the camera delivers it: keypoints are projected, templates drawn and
    measurements taken with fx != fy and with distortion; no image is ever undistorted.

    Camera frame: x right, y down, z forward. Pixel (0, 0) is the centre of the top-left pixel.
    """
    @overload
    def __init__(self) -> None:
        """An empty camera: imageSize() is 0 x 0."""
        ...
    @overload
    def __init__(self, cameraMatrix: NDArray[Any], distCoeffs: NDArray[Any], imageSize: Tuple[int, int]) -> None:
        """cameraMatrix: 3x3, any floating type, [pixel]; the skew is 0 and the last row 0 0 1
        distCoeffs: 0, 4, 5, 8 or 12 coefficients in OpenCV's order (k1, k2, p1, p2[, k3[, k4, k5, k6[, s1..s4]]])
        imageSize: width and height [pixel]
        Raises cv2.error for any other shape, for non-finite values, for a focal length that is not positive or is less than a thousandth of
        the image's side, for an image of more than 32768 pixels a side, and for a distortion that folds or has a pole within the image: there
        several rays would come to one pixel, or none
        """
        ...
    def cameraMatrix(self) -> NDArray[np.float64]:
        """3x3, [pixel]."""
        ...
    def distCoeffs(self) -> NDArray[Any]:
        """1x12 CV_64F, zeros where nothing was given."""
        ...
    def imageSize(self) -> Tuple[int, int]:
        """Width and height [pixel]."""
        ...
    def hasDistortion(self) -> bool:
        """Whether one of the coefficients is not 0."""
        ...
    def projectPoints(self, viewPoints: NDArray[Any], imagePoints: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
        """Projects points of the camera frame to the image.

        viewPoints: N points of the camera frame, N x 3 or 3-channel, floating [m]
        imagePoints: N x 1 CV_64FC2 [pixel]; NaN where a point is not in front of the camera
        """
        ...
    def unprojectPoints(self, imagePoints: NDArray[Any], rays: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
        """The inverse: viewing rays of image points.

        imagePoints: N points, N x 2 or 2-channel, floating [pixel]
        rays: N x 1 CV_64FC2, (x / z, y / z)
        """
        ...
    def fieldOfView(self, window: Tuple[int, int, int, int]) -> Tuple[float, float, float, float]:
        """The rectangle in the plane z = 1 that holds the rays of every point of the image window [x / z, y / z].
        Tangents of the field of view; used to clip geometry before distortion is applied.

        window: part of the image [pixel]
        """
        ...

class CameraPair:
    """Cameras of an endoscope with one or two eyes."""
    def __init__(self) -> None: ...
    left: CameraModel
    right: CameraModel
    """image size 0 x 0 if there is one eye only"""
    right_T_left: NDArray[np.float64]
    """maps the left camera's frame to the right's [m]"""

def isInterlaced(image: NDArray[Any]) -> bool:
    """Whether an image holds two fields of different times, known by their combs: rows next to each other differ more than those
    that are two apart. Only where something moves; some samples are looked at.

    image: CV_8UC1 or CV_8UC3
    """
    ...

def splitFields(image: NDArray[Any], topFirst: bool, first: Optional[NDArray[Any]] = ..., second: Optional[NDArray[Any]] = ...) -> Tuple[NDArray[Any], NDArray[Any]]:
    """Takes the two fields of an interlaced image apart. Each is an image of the full size for the same camera: its own rows are
    where they were, the others are the means of their neighbours, so nothing moves up or down by half a row.

    image: CV_8UC1 or CV_8UC3
    topFirst: whether the rows 0, 2, 4, ... were taken before the others
    first: what was taken first
    second: what was taken half a frame later; noArray() if it is not wanted
    """
    ...

class Mesh:
    """A triangle mesh in the frame of its link [m].

    Vertices on creases are stored once per side, so that a vertex has one normal.
    """
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, vertices: Union[_Sequence[Tuple[float, float, float]], NDArray[Any]], normals: Union[_Sequence[Tuple[float, float, float]], NDArray[Any]], triangles: Union[_Sequence[Tuple[int, int, int]], NDArray[Any]]) -> None: ...
    vertices: NDArray[Any]
    """[m]"""
    normals: NDArray[Any]
    """unit length, outward where the surface is closed; one per vertex"""
    triangles: NDArray[Any]
    """vertex indices"""

@overload
def loadMesh(filename: str, scale: float, link_T_mesh: NDArray[np.float64], maxTriangles: int = ...) -> Mesh:
    """Reads a PLY, STL or OBJ file, by its extension.

    Duplicate points are merged, polygons triangulated, normals computed (creases sharper than 35 degrees stay sharp), and
    a mesh with more triangles than maxTriangles is decimated (quadric error).

    filename: the mesh file
    scale: metres per unit of the file
    link_T_mesh: the mesh's (scaled) frame in the frame wanted
    maxTriangles: 0 = keep all
    Raises cv2.error (StsParseError or StsObjectNotFound) naming the file: missing, truncated, of an unknown type, without
    triangles, or with a vertex that is not finite
    """
    ...

@overload
def loadMesh(filename: str, scale: float = ...) -> Mesh:
    """The same with all triangles, in the mesh's own frame.

    filename: the mesh file
    scale: metres per unit of the file
    """
    ...

class ToolModel:
    """An articulated tool: links and joints, meshes, and the keypoints that name its parts. Immutable.

    The links form a tree. A link's pose in its parent is the modified (Craig) Denavit-Hartenberg transform
    `parent_T_link = Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)`; a joint adds `scale * coordinate` to theta (revolute,
    [rad]) or to d (prismatic, [m]). Several joints may share a coordinate, as the two jaws do.

    The tool file (cv2.FileStorage: YAML, XML or JSON) is described in doc/formats.md.
    """
    @staticmethod
    def load(filename: str, maxTriangles: int = ...) -> ToolModel:
        """Reads a tool file and its meshes (paths relative to the tool file).

        filename: YAML, XML or JSON
        maxTriangles: a tool with more triangles than this is decimated, all meshes to the same closeness; 0 = never
        Raises cv2.error naming the file, the key and what was expected
        """
        ...
    @staticmethod
    def needleDriver() -> ToolModel:
        """The built-in tool: an 8 mm wristed needle driver drawn from its dimensions (shaft radius 4.2 mm, pitch to yaw
        axis 9.1 mm, yaw axis to tip 9.65 mm) on the kinematics of a patient side manipulator, with 14 keypoints.
        """
        ...
    @staticmethod
    def curvedScissors() -> ToolModel:
        """Another built-in tool: curved scissors of 8 mm on the same kinematics. Both blades are bent to the same side, so that no half is the
        other's mirror image. Its keypoints are those that chooseKeypoints() takes.
        """
        ...
    def save(self, filename: str) -> None:
        """Writes the tool file, and its meshes as PLY into the folder `meshes` beside it."""
        ...
    def name(self) -> str:
        """The tool's name."""
        ...
    def coordinateNames(self) -> Tuple[str, ...]:
        """Names of the coordinates, in the order of all `joints` arguments."""
        ...
    def linkNames(self) -> Tuple[str, ...]:
        """Names of the links, parents before their children."""
        ...
    def keypointNames(self) -> Tuple[str, ...]:
        """Names of the keypoints, in the order of keypointPositions()."""
        ...
    def meshes(self) -> Tuple[Mesh, ...]:
        """The meshes that links refer to."""
        ...
    def jointLimits(self) -> NDArray[Any]:
        """How far the joints go: C x 2 CV_64F, least and greatest value of each coordinate [rad or m]; -DBL_MAX and DBL_MAX where that is not known."""
        ...
    def keypointScores(self) -> NDArray[np.float64]:
        """How well keypoints are found, see chooseKeypoints(): 0..1, negative where that is not known."""
        ...
    def coordinateIndex(self, name: str) -> int:
        """Index of the coordinate, or -1."""
        ...
    def endEffectorLink(self) -> int:
        """Index of the link that carries the end effector."""
        ...
    def offsetDeviations(self) -> NDArray[np.float64]:
        """How wrong joint readings may be: prior standard deviation of a constant offset, one per coordinate [rad or m]; 0 = exact,
        or not to be told from an error of the hand-eye calibration. What the links of a coordinate state (Link.offsetDeviation);
        by default 0.03 rad for revolute joints beyond one that slides, and 0 for all others.
        """
        ...
    def getMesh(self, index: int, vertices: Optional[NDArray[Any]] = ..., triangles: Optional[NDArray[Any]] = ...) -> Tuple[NDArray[Any], NDArray[Any]]:
        """A mesh.

        index: mesh index, see linkMesh()
        vertices: V x 3 CV_32F [m], in the frame of its link
        triangles: T x 3 CV_32S
        """
        ...
    def linkMesh(self, link: int) -> int:
        """The mesh that a link carries: an index for getMesh(), or -1.

        link: index
        """
        ...
    def linkPoses(self, joints: NDArray[Any]) -> NDArray[Any]:
        """Poses of all links, as an array.

        joints: one value per coordinate [rad or m], finite
        Returns: base_T_link, L x 4 x 4 CV_64F, in the order of linkNames()
        """
        ...
    def endEffectorPose(self, joints: NDArray[Any]) -> NDArray[np.float64]:
        """The end effector's pose.

        joints: one value per coordinate [rad or m]
        Returns: base_T_tool, the end effector's pose in the base frame
        """
        ...
    def endEffectorFromLinks(self, base_T_link: Union[_Sequence[NDArray[np.float64]], NDArray[np.float64]]) -> NDArray[np.float64]:
        """The end effector's pose, from those of the links.

        base_T_link: as forwardKinematics() or linkPoses() give them
        Returns: base_T_tool
        """
        ...
    def keypointPositions(self, joints: NDArray[Any], basePoints: Optional[NDArray[Any]] = ..., jacobian: Optional[NDArray[Any]] = ...) -> Tuple[NDArray[Any], NDArray[Any]]:
        """Keypoints in the base frame.

        joints: one value per coordinate [rad or m]
        basePoints: K x 3 CV_64F [m]
        jacobian: if wanted, 3K x C CV_64F: d(basePoints) / d(coordinates), rows x, y, z of keypoint 0, then of keypoint 1, ...
        """
        ...
    def pointJacobian(self, base_T_link: Union[_Sequence[NDArray[np.float64]], NDArray[np.float64]], link: int, basePoint: Tuple[float, float, float], jacobian: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
        """The joint Jacobian of any point fixed to a link, as a matrix.

        base_T_link: as forwardKinematics() or linkPoses() give them
        link: the link that carries the point
        basePoint: the point in the base frame [m]
        jacobian: 3 x C CV_64F
        """
        ...

class ToolView:
    """Where a tool is in one frame: what drawing it takes."""
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, camera_T_base: NDArray[np.float64], base_T_link: Union[_Sequence[NDArray[np.float64]], NDArray[np.float64]]) -> None:
        """camera_T_base: camera_T_nominal * nominal_T_base
        base_T_link: one per link, ToolModel.forwardKinematics() or ToolModel.linkPoses()
        """
        ...
    camera_T_base: NDArray[np.float64]
    """camera_T_nominal * nominal_T_base"""
    def linkPoses(self) -> NDArray[Any]:
        """base_T_link as an array, L x 4 x 4 CV_64F."""
        ...

class PartMatch:
    """A place in the image where a part may be."""
    def __init__(self) -> None: ...
    tool: int
    """index of the tool"""
    part: int
    """index of the keypoint"""
    imagePoint: Tuple[float, float]
    """where it was found [pixel]"""
    similarity: float
    """0..1"""
    predictedPoint: Tuple[float, float]
    """where the template expected it [pixel]"""
    templateIndex: int
    """index into the templates that were matched"""

class Rendering:
    """What a MeshRenderer draws: three images of the same size, for one window of the camera's image."""
    def __init__(self) -> None: ...
    window: Tuple[int, int, int, int]
    """the part of the image that was drawn; pixel (0, 0) of the maps is window.tl() of the image"""
    depth: NDArray[Any]
    """CV_32FC1, z in the camera frame [m], 0 where there is nothing"""
    ids: NDArray[Any]
    """CV_8UC1, MeshInstance.id of the nearest surface, 0 where there is nothing"""
    shading: NDArray[Any]
    """CV_8UC1, headlight shading: 255 * |cos| of the angle between normal and viewing ray, 0 where nothing"""

class MeshInstance:
    """A mesh placed in the camera frame."""
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, mesh: int, id: int, camera_T_mesh: NDArray[np.float64]) -> None: ...
    mesh: int
    """what MeshRenderer.addMesh() returned"""
    id: int
    """1..255, written into Rendering.ids"""
    camera_T_mesh: NDArray[np.float64]
    """rigid"""

class MeshRenderer:
    """Draws meshes as the camera would see them: with its intrinsics, its distortion, and hiding each other.

    Derive from it to bring a renderer of your own. Not thread-safe: one renderer for each thread.
    """
    @staticmethod
    def createSoftware() -> MeshRenderer:
        """The default: a z-buffer on the CPU. Needs no display; its result does not depend on the vector instructions there are."""
        ...
    @staticmethod
    def createVTK() -> MeshRenderer:
        """VTK / OpenGL, off screen: through an X server if DISPLAY names one, else X-free through EGL.

        Raises cv2.error (StsNotImplemented) if there is neither
        """
        ...
    def addMesh(self, mesh: Mesh) -> int:
        """Makes a mesh known.

        mesh: with at least one triangle, and a normal for each vertex
        Returns: its handle for MeshInstance.mesh
        """
        ...
    def render(self, camera: CameraModel, window: Tuple[int, int, int, int], instances: _Sequence[MeshInstance], regions: Union[_Sequence[Tuple[int, int, int, int]], NDArray[Any]] = ...) -> Rendering:
        """Draws the instances into the window of the camera's image.

        camera: intrinsics and distortion
        window: part of the image; must lie inside it
        instances: meshes and their poses; may reach behind the camera
        rendering: result
        regions: the parts of the window that are needed, in the image's coordinates; what lies outside of them may stay empty.
        None: all of it is needed
        """
        ...
    def addTool(self, tool: ToolModel) -> int:
        """Makes all meshes of a tool known, one after the other; those of a tool that is known already are not added again.

        tool: whose mesh i gets the handle of the first one + i
        Returns: the handle of the first one
        """
        ...
    def renderTool(self, tool: ToolModel, joints: NDArray[Any], camera_T_base: NDArray[np.float64], camera: CameraModel, depth: Optional[NDArray[Any]] = ..., ids: Optional[NDArray[Any]] = ..., shading: Optional[NDArray[Any]] = ...) -> Tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Draws one tool into a whole image.

        tool: addTool() is called for it
        joints: one value per coordinate of the tool [rad or m]
        camera_T_base: the arm's base in the camera frame
        camera: intrinsics and distortion
        depth: CV_32FC1 [m], 0 where there is nothing
        ids: CV_8UC1, 1 + index of the link, 0 where there is nothing
        shading: CV_8UC1
        """
        ...

class PartTemplate:
    """How a part of a tool should look around its keypoint (paper, Sec. 2.1)."""
    def __init__(self) -> None: ...
    @property
    def tool(self) -> int:
        """index of the tool"""
        ...
    @property
    def part(self) -> int:
        """index of the keypoint"""
        ...
    @property
    def imagePoint(self) -> Tuple[float, float]:
        """where the keypoint is expected [pixel]"""
        ...
    @property
    def anchor(self) -> Tuple[int, int]:
        """imagePoint, rounded"""
        ...
    @property
    def viewPoint(self) -> Tuple[float, float, float]:
        """the keypoint in the camera frame the template was drawn in [m]"""
        ...
    @property
    def bounds(self) -> Tuple[int, int, int, int]:
        """of the features, relative to the anchor [pixel]"""
        ...
    def getFeatures(self) -> NDArray[Any]:
        """Features as N x 3 CV_32S: x and y from the anchor [pixel], bin of the orientation, 0..7."""
        ...

class PartTemplateRenderer:
    """Cuts part templates from a drawing of the tools (paper, Sec. 2.1).

    All tools are in one drawing, so that they hide each other. A keypoint gets a template if it lies in the image and the depth
    map does not hide it. The template's box has a fixed size on the tool, so its size in the image follows the depth.
    """
    class Params:
        def __init__(self) -> None: ...
        boxSize: float
        """side of the box on the tool [m]; default 0.011"""
        minFeatures: int
        """a template with fewer is dropped; default 30"""
        maxFeatures: int
        """features kept, spread over the box; default 250 (paper's release: 63)"""
        magnitudeThreshold: float
        """see quantizeOrientations(); default 80 (paper's release: 50): the gentle shading of a round shaft is no edge in an image"""
        depthSlack: float
        """a keypoint this far behind the drawn surface is visible [m]; 0.001, as the paper's release"""
        wholeTool: bool
        """rendering() shows the tool as far as it lies in the image, not only its parts; default false"""
        tipDepthSlack: float
        """the same for keypoints on the last links of the chain (tips) [m]; 0.003, as the paper's release"""

    @staticmethod
    def create(renderer: Optional[MeshRenderer] = ..., params: PartTemplateRenderer.Params = ...) -> PartTemplateRenderer:
        """renderer: draws the tools; none: MeshRenderer.createSoftware()
        params: sizes and thresholds
        """
        ...
    def addTool(self, model: ToolModel) -> int:
        """Adds a tool.

        model: the tool
        Returns: its index
        """
        ...
    def render(self, camera: CameraModel, views: _Sequence[ToolView], tool: int, scale: float = ..., rotation: float = ...) -> Tuple[PartTemplate, ...]:
        """Draws the tools and cuts the templates of one of them.

        camera: intrinsics and distortion
        views: one per tool added; a tool without link poses may be anywhere, and is not drawn
        tool: the tool wanted; the others only hide it
        templates: result; those of invisible parts are missing
        scale: the tool is drawn this much larger, about the centre of its keypoints (initialisation: 0.8, 1, 1.2)
        rotation: the tool is turned by this about the viewing ray through the centre of its keypoints [rad]
        (initialisation: 0, +-15 degrees)
        """
        ...
    def renderTool(self, camera: CameraModel, camera_T_base: NDArray[np.float64], joints: NDArray[Any], scale: float = ..., rotation: float = ...) -> Tuple[PartTemplate, ...]:
        """The same for a single tool, from its joints.

        camera: intrinsics and distortion
        camera_T_base: pose of the arm's base in the camera frame; the model is that of index 0
        joints: one value per coordinate [rad or m]
        scale: see render()
        rotation: see render()
        """
        ...
    def model(self, tool: int) -> ToolModel:
        """A tool that was added.

        tool: index
        """
        ...
    def rendering(self) -> Rendering:
        """The last drawing: of the parts' surroundings, or of the whole tool. A copy, which stays as it is."""
        ...

def quantizeOrientations(image: NDArray[Any], orientations: Optional[NDArray[Any]] = ..., magnitudeThreshold: float = ...) -> NDArray[Any]:
    """Quantised gradient orientations (QGO) of an image (paper, Sec. 2.1; [hinterstoisser2012gradient]).

    Blur (7x7, sigma 1.41), 3x3 Sobel in the channel whose gradient is strongest (largest |gx| + |gy|), direction modulo 180 degrees in eight bins of
    22.5 degrees (bin 0 is centred on a horizontal gradient), and a 3x3 vote: a pixel keeps an orientation if its gradient is
    strong enough and at least five of the nine pixels around it share one bin; it gets that bin. Integer arithmetic throughout.

    image: CV_8UC1 or CV_8UC3, any size; pixels beyond its border repeat it
    orientations: CV_8UC1, same size: 0 or one bit, 1 << bin
    magnitudeThreshold: least Sobel magnitude of the blurred image [grey levels x 4] that counts as an edge
    """
    ...

def quantizeOrientationsInWindow(image: NDArray[Any], window: Tuple[int, int, int, int], orientations: Optional[NDArray[Any]] = ..., magnitudeThreshold: float = ...) -> NDArray[Any]:
    """The same for a window of a larger image: pixels beyond the window but inside the image are used, so that the result
    is quantizeOrientations() of the whole image, cut out.

    image: CV_8UC1 or CV_8UC3, any size; pixels beyond its border repeat it
    window: part of the image; must lie inside it
    orientations: CV_8UC1 of the window's size
    magnitudeThreshold: least Sobel magnitude of the blurred image [grey levels x 4] that counts as an edge
    """
    ...

def spreadOrientations(orientations: NDArray[Any], spread: Optional[NDArray[Any]] = ..., size: int = ...) -> NDArray[Any]:
    """Spreads orientations: each pixel gets the bits of all pixels of the size x size square around it
    ([hinterstoisser2012gradient], Sec. 3.3). Tolerates misplacement by size / 2 pixels.

    orientations: CV_8UC1 bit sets
    spread: CV_8UC1, same size
    size: odd side of the square [pixel]
    """
    ...

def orientationResponse(spread: NDArray[Any], bin: int, response: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """Similarity of every spread bit set to one orientation: 4 if it holds the orientation, 1 if it holds a neighbouring
    one, else 0.

    spread: CV_8UC1 bit sets
    bin: 0..7
    response: CV_8UC1, same size, values 0, 1, 4
    """
    ...

class QGOMatcher:
    """Finds part templates in an image by their quantised gradient orientations (paper, Sec. 2.1).

    The similarity of a template at a place is the mean, over its features, of 1 where the spread image holds the feature's
    orientation, 1/4 where it holds a neighbouring one, else 0; sums of small integers over sliding windows, no per-pixel loop over
    features.

    Gradients count where they are strong for the picture, not for a fixed light: compared to the median of their tile of 128 x 128
    pixels, and of all that is prepared, whichever is less. Half of a picture is texture and noise, no outline of a tool. Of noise a
    fifth is more than 1.5 times as strong as its median, and then five neighbours of nine must agree on the direction. So a dim
    picture, one in haze and one with another tone curve have nearly the same orientations.

    A window is searched place by place. The whole image is searched in cells of 4 x 4 places first, whose similarity bounds that of
    their places from above; cells are then looked into, the most promising first, until the best place found beats all bounds that
    are left. So the best match of a template is that of a search place by place, unless thousands of cells promise as much (a
    template that is nowhere in an image full of edges). Its further matches come from the cells that were looked into, at least
    eight a candidate if that many can hold one: they have the places and similarities they have, but one may be missed.

    Only what is asked for is made: responses of the area that windows need at the first match in windows, cells at the first search
    of the whole image. Memory is kept from image to image.
    """
    class Params:
        def __init__(self) -> None: ...
        magnitudeThreshold: float
        """see quantizeOrientations(); the most that is asked for; default 50, as the paper's release"""
        contrast: float
        """gradients must be so many times the median around, where that is less than magnitudeThreshold (then up to 127); 0 = not looked at; default 1.5, from rendered scenes (1.5 to 3)"""
        leastMagnitude: float
        """contrast never asks for less; default 8: a blurred edge of four grey levels, as rounding and compression make"""
        spread: int
        """see spreadOrientations() [pixel]; default 5, as the paper's release"""
        candidates: int
        """at most so many matches a part; default 5 (paper: top 5)"""
        suppressionRadius: int
        """a match suppresses weaker ones of its part this near [pixel]; default 6"""
        minSimilarity: float
        """weaker matches are dropped, 0..1; default 0.5"""
        relativeSimilarity: float
        """as are those weaker than this share of the part's best; default 0.7"""

    @staticmethod
    def create(params: QGOMatcher.Params = ...) -> QGOMatcher: ...
    def setImage(self, image: NDArray[Any], roi: Tuple[int, int, int, int] = ..., mask: NDArray[Any] = ...) -> None:
        """Prepares the image for matching.

        image: CV_8UC1 or CV_8UC3, any size; is not kept
        roi: only windows with their templates inside it can be matched; empty = the whole image
        mask: CV_8UC1 of the image's size: there are no orientations where it is 0; none: everywhere
        """
        ...
    def match(self, templates: _Sequence[PartTemplate], windows: Union[_Sequence[Tuple[int, int, int, int]], NDArray[Any]]) -> Tuple[PartMatch, ...]:
        """Finds templates in the prepared image. Features outside the prepared region count as not found.

        templates: what to look for
        windows: where the keypoints of each template may be [pixel]; one per template, or none for the whole image; a window
        that holds the image is the whole image
        matches: candidates, sorted by falling similarity
        """
        ...
    def similarityMap(self, partTemplate: PartTemplate, window: Tuple[int, int, int, int], similarity: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
        """The similarity of one template over a window, before any selection.

        partTemplate: what to look for
        window: where its keypoint may be [pixel]
        similarity: CV_16UC1 of the window's size: sum over features of 4, 1 or 0
        """
        ...
    def orientations(self, orientations: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
        """What is matched, before it is spread.

        orientations: of the prepared region, as of quantizeOrientations()
        """
        ...

class GeometricContextVerifier:
    """Keeps the matches of one tool whose arrangement in the image is that of the drawing (paper, Sec. 2.2).

    Two matches of different parts, drawn in PROSAC order [chum2005matching], span a polar grid in the image and one in the
    drawing: centre on the first point, axis through the second. Another match agrees if it falls into the zone of its part in
    both grids. The sample with most inliers wins (ties: the larger sum of similarities); a part has at most one inlier. With Params.centredZones = false the first sample
    that Params.minInliers agree with is taken, as in the paper.
    """
    class Params:
        def __init__(self) -> None: ...
        zoneAngle: float
        """width of a zone [rad]; 30 degrees, as in the paper"""
        zoneRadius: float
        """depth of a zone [pixel]; 10, as in the paper"""
        centredZones: bool
        """zones centred on the predicted points; false: fixed cells of the grid, as in the paper"""
        minInliers: int
        """fewer are no agreement; 4, as in the paper"""
        maxIterations: int
        """samples at most; 100, as in the paper"""
        maxScale: float
        """samples that scale the arrangement by more than this, or less than its inverse, are skipped; 0 = any"""
        maxRotation: float
        """samples that turn the arrangement by more than this are skipped [rad]; 0 = any"""
        seed: int
        """of the sampling"""

    @staticmethod
    def create(params: GeometricContextVerifier.Params = ...) -> GeometricContextVerifier:
        """params: zones and limits"""
        ...
    def verify(self, matches: _Sequence[PartMatch]) -> Tuple[bool, Tuple[PartMatch, ...]]:
        """Keeps what agrees.

        matches: candidates of one tool, sorted by falling similarity
        inliers: those that agree, at most one a part, sorted by part; empty after false
        Returns: whether at least Params.minInliers agree
        """
        ...
    def sample(self) -> Tuple[PartMatch, ...]:
        """The two matches that span the grids the inliers of the last verify() agree in: the centre, and a point on the axis.
        Empty after false.
        """
        ...

def projectKeypoints(camera: CameraModel, state: NDArray[Any], nominalPoints: NDArray[Any], imagePoints: Optional[NDArray[Any]] = ..., jacobian: Optional[NDArray[Any]] = ...) -> Tuple[NDArray[Any], NDArray[Any]]:
    """The measurement function h(x) of the paper (Sec. 2.3, eq. 3-5): where keypoints of the nominal camera frame are seen.

    camera: intrinsics and distortion
    state: 6 values: x = (theta_x, theta_y, theta_z [rad], r_x, r_y, r_z [m]), the correction
    camera_T_nominal = (Rot_z(theta_z) Rot_y(theta_y) Rot_x(theta_x), r)
    nominalPoints: N x 3, 64-bit: keypoints in the nominal camera frame, nominal_T_base * basePoint [m]
    imagePoints: N x 1 CV_64FC2 [pixel]; NaN where a point is not in front of the camera
    jacobian: if wanted, 2N x 6 CV_64F: dh / dx, rows u, v of point 0, then of point 1, ...
    """
    ...

def correctionFromState(state: NDArray[Any]) -> NDArray[np.float64]:
    """camera_T_nominal of a state (theta_x, theta_y, theta_z [rad], r_x, r_y, r_z [m])."""
    ...

def stateFromCorrection(camera_T_nominal: NDArray[np.float64], state: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """The state, 6 x 1 CV_64F, of a camera_T_nominal: the inverse of correctionFromState()."""
    ...

def solveEPnP(camera: CameraModel, nominalPoints: NDArray[Any], imagePoints: NDArray[Any], maxError: float = ...) -> Tuple[bool, NDArray[np.float64]]:
    """EPnP on verified matches: the paper's start, and its per-frame baseline.

    camera: intrinsics and distortion
    nominalPoints: N x 3, 64-bit [m], N >= 4
    imagePoints: N x 2, 64-bit [pixel]
    camera_T_nominal: result; unchanged after false
    maxError: if positive, the pose is sought by RANSAC with this reprojection error [pixel]
    Returns: whether a pose was found that has all points in front of the camera
    """
    ...

class ToolPoseEKF:
    """The extended Kalman filter of the paper (Sec. 2.3): estimates the error of the hand-eye calibration.

    State x: rotation (Euler angles) and translation of camera_T_nominal. Process: constant, with noise Q. Measurement: image points
    of keypoints, z = h(x) + noise R. Parts that were not found have no rows. P is updated in Joseph's form.
    """
    class Params:
        def __init__(self) -> None: ...
        initialRotation: float
        """standard deviation of the first state [rad]"""
        initialTranslation: float
        """the same [m]"""
        processRotation: float
        """process noise, standard deviation a frame [rad]"""
        processTranslation: float
        """the same [m]"""
        measurementNoise: float
        """standard deviation of an image point [pixel]"""
        gate: float
        """points with a larger squared Mahalanobis distance are left out; 13.8 = 99.9 % of chi-square with 2 dof; 0 = none"""
        minPoints: int
        """with fewer points inside the gate nothing is updated; default 1"""

    @staticmethod
    def create(camera: CameraModel, params: ToolPoseEKF.Params = ...) -> ToolPoseEKF:
        """camera: intrinsics and distortion
        params: noise and gate
        """
        ...
    def reset(self, camera_T_nominal: NDArray[np.float64]) -> None:
        """Starts anew from a correction (the unit matrix: the hand-eye calibration itself) with the initial covariance."""
        ...
    def changeFrames(self, now_T_camera: NDArray[np.float64], nominal_T_now: NDArray[np.float64]) -> None:
        """Takes a correction and its covariance to another pair of frames, as when the camera moves or another calibration is given:
        camera_T_nominal <- now_T_camera camera_T_nominal nominal_T_now.

        now_T_camera: rigid
        nominal_T_now: rigid
        """
        ...
    def predict(self) -> None:
        """One frame passes: P grows by Q."""
        ...
    def correct(self, nominalPoints: NDArray[Any], imagePoints: NDArray[Any], used: Optional[NDArray[Any]] = ...) -> Tuple[bool, NDArray[Any]]:
        """Takes in measured keypoints.

        nominalPoints: N x 3, 64-bit: keypoints in the nominal camera frame [m]
        imagePoints: N x 2, 64-bit: where they were found [pixel]
        used: if wanted, N x 1 CV_8U: 1 where the point passed the gate
        Returns: whether the state was updated; false if fewer than Params.minPoints passed or the innovation covariance is singular: nothing changes then
        """
        ...
    def correction(self) -> NDArray[np.float64]:
        """camera_T_nominal."""
        ...
    def state(self) -> NDArray[Any]:
        """6 x 1 CV_64F, see projectKeypoints()."""
        ...
    def covariance(self) -> NDArray[Any]:
        """6 x 6 CV_64F, order of the state."""
        ...
    def nis(self) -> float:
        """Normalised innovation squared of the last correct(), per degree of freedom; 0 before the first."""
        ...
    def imageCovariance(self, nominalPoint: Tuple[float, float, float]) -> NDArray[np.float64]:
        """Covariance of where a keypoint will be seen, H P H^T [pixel^2], without measurement noise."""
        ...
    def poseCovariance(self, nominalTool: Tuple[float, float, float]) -> NDArray[np.float64]:
        """Covariance of camera_T_tool, (rotation vector, translation) in the camera frame, from that of the state.

        nominalTool: origin of the tool in the nominal camera frame [m]
        """
        ...

class ContourPoint:
    """A point of a tool's outline or of a crease, and where the image has an edge on its normal."""
    def __init__(self) -> None: ...
    link: int
    """index of the link it lies on"""
    linkPoint: Tuple[float, float, float]
    """in the link's frame [m]"""
    linkDirection: Tuple[float, float, float]
    """along the edge, in the link's frame; the tool is on its left, seen from the camera"""
    imagePoint: Tuple[float, float]
    """where it is expected [pixel]"""
    normal: Tuple[float, float]
    """unit vector in the image, out of the tool"""
    crease: bool
    """an edge inside the tool's image, not its outline"""
    found: bool
    """whether the image has an edge near it"""
    offset: float
    """where, from imagePoint along the normal [pixel]"""
    deviation: float
    """standard deviation of the offset, as edges of this strength have it [pixel]"""
    clipped: int
    """what the sensor has clipped to white beside the edge: 1 outside the tool, -1 inside, 0 neither; its light blooms over the edge"""
    strength: float
    """of that edge, change of the strongest channel [grey levels a pixel]"""

class ToolContour:
    """The outline of a tool: from its meshes' edges, so exact to a fraction of a pixel, where a drawing shows that they are seen.

    An edge between a triangle that faces the camera and one that does not is part of the outline if the drawing has the tool on one
    side of it and neither this nor another tool on the other. Sharp edges between two triangles that face the camera are creases.
    """
    class Params:
        def __init__(self) -> None: ...
        spacing: float
        """distance of the points [pixel]; default 5: nearer ones tell the same"""
        maxPoints: int
        """more than these are thinned out; default 200"""
        creaseAngle: float
        """edges sharper than this are creases [rad]; 0 = no creases"""

    @staticmethod
    def create(model: ToolModel, params: ToolContour.Params = ...) -> ToolContour: ...
    def sample(self, camera: CameraModel, view: ToolView, rendering: Rendering, id: int) -> Tuple[ContourPoint, ...]:
        """Points of the outline and the creases, where a drawing shows that they are seen.

        camera: of the drawing
        view: of this tool
        rendering: a drawing of all tools from this view; points outside its window are left out
        id: of this tool's meshes in the drawing
        points: result
        """
        ...
    def sampleTool(self, camera: CameraModel, camera_T_base: NDArray[np.float64], joints: NDArray[Any]) -> Tuple[ContourPoint, ...]:
        """The same for a single tool, which is drawn for it.

        camera: intrinsics and distortion
        camera_T_base: pose of the arm's base in the camera frame
        joints: one value per coordinate [rad or m]
        """
        ...

def placeContour(camera: CameraModel, view: ToolView, points: _Sequence[ContourPoint]) -> Tuple[ContourPoint, ...]:
    """Moves contour points to where another view has them, as long as it is so near that the same points of the tool make its
    outline: to a tenth of a pixel for turns up to 0.05 rad.

    camera: of the view
    view: of their tool
    points: imagePoint and normal are set; points that are not in front of the camera are dropped
    """
    ...

class ContourSearch:
    """Where edges are sought, and which are believed."""
    def __init__(self) -> None: ...
    halfWindow: float
    """on both sides of the expected place, 1 to 40 [pixel]"""
    preference: float
    """edges this far from the expected place count 0.6 of one there, as a share of halfWindow; 0 = all the same"""
    minStrength: float
    """weaker edges are none [grey levels a pixel]; the most that is asked for"""
    contrast: float
    """edges must be so many times the median strength along the normals, where that is less than minStrength; 0 = not looked at; default 1.1: a ramp has none"""
    leastStrength: float
    """contrast never asks for less; default 1: a blurred edge of three grey levels"""
    ambiguity: float
    """a point with a second edge more than this share as likely as the first is left out"""

def matchContour(image: NDArray[Any], points: _Sequence[ContourPoint], search: ContourSearch) -> Tuple[int, Tuple[ContourPoint, ...]]:
    """Looks for an edge on the normal of each point, to a fraction of a pixel: the maximum of the image's gradient along the
    normal, over all channels, nearer ones preferred. In dim or hazy pictures weaker edges are believed, and their deviations are
    smaller, as much as the threshold is. Rendered scenes in good light have medians of 5.5 to 7.5, where minStrength rules.

    image: CV_8UC1 or CV_8UC3
    points: their found, offset and strength are set
    search: where to look
    Returns: how many were found
    """
    ...

class ReadingErrors:
    """What METHOD_FULL has learnt of what is wrong with the readings of a tool's joints: constants that are the robot's and its
    instrument's and will be the same tomorrow. ToolTracker.readingErrors(), setReadingErrors(); files: readToolState(), writeToolState().
    """
    def __init__(self) -> None: ...
    names: Tuple[str, ...]
    """of the constants: a coordinate and `offset`, `gain`, `play` or `coupling`, as `wrist_yaw gain`; `delay`"""
    values: NDArray[np.float64]
    """of each [rad or m, of the travel, rad, of the travel, s]"""
    covariance: NDArray[Any]
    """CV_64F, of the values; empty: nothing is known"""
    reference: NDArray[np.float64]
    """one per coordinate: readings that travel is counted from [rad or m]"""

class ArticulatedPoseEKF:
    """The filter of METHOD_FULL: the error of the hand-eye calibration and those of the joint readings.

    State: the correction camera_T_nominal and, of each coordinate with ToolModel.offsetDeviations() > 0 (the first ten), constants of what
    is wrong with its readings: an offset, a gain, play, and the coupling to the coordinate before it; and one time by which all readings are
    late. The sum of them at this frame's
    readings, d, is added to these. The state's error is (omega, v, theta), omega and v a small motion of the tool about its own centre c in
    the camera frame, `camera_T_nominal <- Trans(c + v) Exp(omega) Trans(-c) camera_T_nominal`, theta that of the constants; so rotation and
    translation are nearly independent, and P is moved to the new centre as the tool moves. Process: constant, with noise Q. Measurements: points of
    parts and edges on contour normals, of one camera or several, all at once.
    """
    class Params:
        def __init__(self) -> None: ...
        initialRotation: float
        """standard deviation of the hand-eye calibration [rad]"""
        initialTranslation: float
        """the same, at the tool [m]"""
        processRotation: float
        """process noise, standard deviation in a frame of 40 ms; its variance grows with time [rad]"""
        processTranslation: float
        """the same [m]"""
        processJoint: float
        """the same, of what is wrong with the joints' readings, as a share of its prior deviation; of offsets, which take up what the others do not explain: theirs is a fifth"""
        gain: float
        """prior standard deviation of a turning joint's gain, of its travel; 0 = none, as of the next two; defaults: what a real PSM had"""
        play: float
        """the same, of half its play [rad]"""
        coupling: float
        """the same, of a share of the travel of the coordinate before it"""
        delay: float
        """the same, of the time between image and readings [s]; what is known of it is taken off before"""
        exact: float
        """prior probability that there is neither gain nor play nor coupling at all, and that there is no delay; 0 = there are"""
        pointNoise: float
        """standard deviation of a part's image point [pixel]"""
        gate: float
        """points with a larger squared Mahalanobis distance are left out; 13.8 = 99.9 % of chi-square with 2 dof"""
        contourNoise: float
        """standard deviation of an edge along its normal [pixel]"""
        edgeBias: float
        """the same, of what displaces all edges of an eye and frame together, as codecs do [pixel]"""
        bloom: float
        """the same, of those beside what is clipped to white [pixel]"""
        jointOffsets: bool
        """whether the readings may have offsets"""
        contourCorrelation: float
        """so many neighbouring contour points tell as much as one"""

    @staticmethod
    def create(model: ToolModel, nominal_T_base: NDArray[np.float64], params: ArticulatedPoseEKF.Params = ...) -> ArticulatedPoseEKF:
        """model: the tool
        nominal_T_base: the hand-eye calibration
        params: noise and gate
        """
        ...
    @overload
    def reset(self, correction: NDArray[np.float64]) -> None:
        """Back to the readings themselves, with the initial covariance.

        correction: camera_T_nominal; unit: the hand-eye calibration
        """
        ...
    @overload
    def reset(self) -> None:
        """Back to the readings and the hand-eye calibration themselves, with the initial covariance."""
        ...
    def predict(self, joints: Union[_Sequence[float], NDArray[np.float64]], growth: float = ..., seconds: float = ...) -> None:
        """One frame passes.

        joints: readings, one per coordinate [rad or m]
        growth: factor on the deviations of Q
        seconds: since the last frame; 0 = it is the same one once more, or not known: then nothing is learnt of the delay, and Q is that
        of 40 ms
        """
        ...
    def inflate(self, rotation: float, translation: float) -> None:
        """Takes back everything since the last predict(); the prediction's P grows by these standard deviations, as after a push.

        rotation: [rad]
        translation: [m]
        """
        ...
    def undo(self) -> None:
        """Takes back everything since the last predict()."""
        ...
    def begin(self) -> None:
        """Nothing is measured yet."""
        ...
    def addPoints(self, camera: CameraModel, eye_T_camera: NDArray[np.float64], parts: Union[_Sequence[int], NDArray[Any]], imagePoints: Union[_Sequence[Tuple[float, float]], NDArray[Any]], noise: Union[_Sequence[float], NDArray[np.float64]] = ..., tolerance: float = ...) -> Tuple[int, NDArray[Any]]:
        """Points of parts.

        camera: that saw them
        eye_T_camera: the camera frame of the state in that of this camera; unit if it is the same
        parts: keypoint indices
        imagePoints: where they were found [pixel]
        used: 1 where the point passed the gate
        noise: factor on Params.pointNoise, one each; none: 1
        tolerance: points that are farther off than this (and than the noise) from where the state has them count little; as the
        state is that of the last solve(), not before the first one of a frame [pixel]
        Returns: how many passed
        """
        ...
    def addContour(self, camera: CameraModel, eye_T_camera: NDArray[np.float64], points: _Sequence[ContourPoint], tolerance: float) -> int:
        """Edges on the normals of a contour.

        camera: that saw them
        eye_T_camera: see addPoints()
        points: those found are taken
        tolerance: edges that are farther off than this, their noise and what is not known of the state explain count little, beyond three times of it nothing [pixel]
        Returns: how many passed
        """
        ...
    def surprise(self, rotation: float, translation: float) -> float:
        """How much better a push of this size before this frame explains what was added: half the difference of its squared
        Mahalanobis distances, a log likelihood ratio but for the determinants.

        rotation: [rad]
        translation: [m]
        """
        ...
    def solve(self) -> bool:
        """The correction by all that was added.

        Returns: false if the equations can't be solved; nothing changes then
        """
        ...
    def copyTo(self, other: ArticulatedPoseEKF) -> None:
        """Makes another filter of the same tool what this one is.

        other: changes
        """
        ...
    def readingErrors(self) -> ReadingErrors:
        """The constants of the readings' errors."""
        ...
    def setReadingErrors(self, errors: ReadingErrors) -> None:
        """What was learnt of them before: where reset() begins, in place of nothing; calls it. Offsets and the delay may have changed since
        by as much as they are unknown by without this.

        errors: of the same tool, as readingErrors() gave them; without names: nothing is known
        Raises cv2.error for other constants than those of this filter, numbers beyond 1e4, and a covariance that is none
        """
        ...
    def setHandEye(self, nominal_T_base: NDArray[np.float64]) -> None:
        """The calibration is another one: the tool, and what is known of its place, stay where they are, so the correction changes.

        nominal_T_base: rigid
        """
        ...
    def moveCamera(self, now_T_before: NDArray[np.float64]) -> None:
        """The camera has moved, and everything moves in its frame: the tool, its covariance, and where the calibration has the base.

        now_T_before: pose of the camera before the move in the frame of the one after it, rigid
        """
        ...
    def view(self) -> ToolView:
        """The tool as it is believed to be."""
        ...
    def correction(self) -> NDArray[np.float64]:
        """camera_T_nominal."""
        ...
    def delay(self) -> float:
        """The image shows the joints as they are read so much later; negative: earlier [s]."""
        ...
    def offsets(self) -> NDArray[np.float64]:
        """One per coordinate, to be added to the reading [rad or m]."""
        ...
    def joints(self) -> NDArray[np.float64]:
        """One per coordinate: the readings with their offsets, and no jaw beyond its stop [rad or m]."""
        ...
    def covariance(self) -> NDArray[Any]:
        """CV_64F, of (omega, v, d): d is the sum of what is wrong with each reading now."""
        ...
    def edgeBias(self, clipped: int) -> float:
        """What displaced edges in the last solve(), along their normals [pixel].

        clipped: ContourPoint.clipped
        """
        ...
    def nis(self) -> float:
        """Normalised innovation squared of the last solve(), per degree of freedom."""
        ...
    def imageCovariance(self, camera: CameraModel, eye_T_camera: NDArray[np.float64], part: int) -> NDArray[np.float64]:
        """Covariance of where a keypoint will be seen [pixel^2], without measurement noise.

        camera: that will see it
        eye_T_camera: see addPoints()
        part: index of the keypoint
        """
        ...
    def poseCovariance(self) -> NDArray[np.float64]:
        """Covariance of camera_T_tool: (rotation vector [rad], translation [m]), both in the camera frame."""
        ...

def stateName(state: int) -> str:
    """`initializing`, `tracking`, `coasting` or `lost`, as poses files have it.

    state: see TrackingState
    """
    ...

class ToolEstimate:
    """The tracker's answer for one tool and one frame."""
    def __init__(self) -> None: ...
    state: int
    """see TrackingState"""
    camera_T_tool: NDArray[np.float64]
    """pose of the end effector in the camera frame [m]"""
    camera_T_nominal: NDArray[np.float64]
    """the correction of the hand-eye calibration"""
    covariance: NDArray[np.float64]
    """of camera_T_tool: (rotation vector [rad], translation [m]), both in the camera frame; zero with METHOD_EPNP"""
    jointOffsets: NDArray[np.float64]
    """METHOD_FULL: one per coordinate, what is wrong with the reading and is added to it [rad or m], and 0 where ToolModel.offsetDeviations() is; else zeros"""
    joints: NDArray[np.float64]
    """one per coordinate, those the pose is of: the readings, as they are `delay` later, with jointOffsets, and no jaw beyond its stop [rad or m]"""
    visibleParts: int
    """parts that had a template, in the left image"""
    inliers: int
    """matches in the left image that agreed on the geometric context and went into the pose; 0 if nothing was measured, or METHOD_FULL followed the outline alone"""
    similarity: float
    """mean similarity of the inliers, 0..1; 0 without inliers"""
    contourSupport: float
    """METHOD_FULL: share of the visible outline, in both eyes, whose strongest edge within 6 px is at most 1.5 px off (pixels at 720 px width), 0..1; else 0. Of the last pose that was looked at, also if it was not believed"""
    confidence: float
    """METHOD_FULL: probability that the pose is within 5 mm and 10 px of the truth, from this frame's evidence and from how sure the pose was that it follows from (src/track/evidence.hpp); else, and where nothing was measured, 0"""
    nis: float
    """of the inliers, normalised innovation squared per degree of freedom; about 1 if image points are as bad as the filter takes them for, less if they are better; 0 with METHOD_EPNP and without inliers"""
    delay: float
    """METHOD_FULL: the image shows the joints as they are read so much later, negative: earlier [s]; else 0"""
    matches: Tuple[PartMatch, ...]
    """the inliers"""
    skippedReadings: int
    """frames since addTool() or reset() whose readings no joint can have: further beyond ToolModel.jointLimits() than these are apart, or without limits 10 m or 100 turns. Such a frame has the readings of the frame before"""

class StageTime:
    """How long a stage of ToolTracker.update() takes. A frame is one sample: the sum over all tools and eyes, 0 if the stage was not reached."""
    def __init__(self) -> None: ...
    name: str
    """`render`, `image`, `match`, `verify`, `filter`, `contour` (METHOD_FULL) or `total`, all of update()"""
    calls: int
    """frames; without any, the times are 0"""
    last: float
    """of the last frame [s]"""
    mean: float
    """[s]"""
    min: float
    """[s]"""
    max: float
    """[s]"""

class ToolTracker:
    """Finds the pose of articulated tools in the camera from video and joint readings.

    METHOD_PAPER, per frame (paper, Sec. 2): the tools are drawn as the kinematics and the last correction say they look (Sec. 2.1);
    part templates are cut from the drawing (PartTemplateRenderer), found in the image (QGOMatcher), kept where their arrangement
    agrees (GeometricContextVerifier, Sec. 2.2), and fused with the kinematics (ToolPoseEKF, Sec. 2.3). METHOD_EPNP has EPnP in
    place of the filter.

    METHOD_FULL, per frame:
    - Parts are drawn, found and verified as above, in each eye. Samples of the geometric context that scale or turn too much are
      skipped and the best one is taken, not the first: fewer wrong inliers.
    - ArticulatedPoseEKF takes them in. It has what is wrong with each wrist and jaw reading in its state (offset, gain, play, coupling),
      beside the correction: cables stretch, and no rigid correction repairs a reading.
    - The outline is placed where this pose has it (ToolContour), edges are sought on its normals (matchContour()), within 8, 5 and
      3 pixels in turn (at 720 px width), and taken in together with the parts. Parts tell from far off where the tool is, to some
      pixels; edges are many and exact to a fraction of a pixel, but need a pose within some pixels to begin with.
    - Evidence is the log odds of the pose being right: how many parts were found and how alike, how much of the outline is where the pose
      has it, and how badly the points fit (a logistic model, fitted to poses that are known to be right or wrong). Tissue may look like parts,
      or like an outline, but not like both at once. One that follows from the frame before has that one's log odds besides, up to a limit,
      so an outline alone does for a while. A first pose needs more of its own, and one that is to count as tracking without a second frame
      most. ToolEstimate.confidence is the probability. (Coefficients and thresholds: src/track/evidence.hpp.)
    - A push of the camera: where points or edges fit badly to a correction that changes slowly, the frame is measured once more with
      P grown by what a push does; if that has more evidence it is kept, and the process noise stays raised for some frames. If it has
      not and the points fit badly, they are the wrong ones: the outline alone is taken. During a push, and where there is much less evidence
      than in the frames before, nearer edges and other depths are tried as well.
    - First pose: nine drawings (paper, Sec. 2.1: scales 0.8, 1, 1.2, rotations 0, +-15 degrees); the three with the largest summed
      similarity are fitted, parts and outline, in four rounds each; the one with the most evidence is taken, as the summed similarity
      alone does not tell good from bad. If none is good enough, the next frames do the same about the calibration turned out of the image
      by 10 degrees, to one side after the other. The process noise is raised for the frames after a first pose: two may look alike in one frame.
    - A tool that is not seen is sought in every frame with one of the nine drawings, in turn about its last pose and about the
      hand-eye calibration itself, since either may be the better guess. What is found there must be confirmed by the next frames;
      else the tool goes back to the last pose that was tracked. Meanwhile P grows.

    Images 1440 pixels wide and more are reduced by a whole number first, since gradients and tolerances are made for pixels of an
    image about 720 wide.

    Each tool has a state of its own. The result depends on the input alone: same images, times and joints, same estimates.

    **Threads.** One thread at a time may call a tracker; different trackers do not know of each other. renderAhead() has the only thread
    of its own. **Cost**, some 720 pixels wide: update() takes milliseconds (doc/performance.md), ten times as long where a tool is sought;
    addTool(), replaceTool(), removeTool() and setRightCamera() milliseconds; all others microseconds. **Messages**, of changes of
    state, go to OpenCV's log at the level info: none by default.
    """
    class Params:
        def __init__(self) -> None: ...
        method: int
        """see TrackingMethod; default METHOD_FULL"""
        jointOffsets: bool
        """METHOD_FULL: joint readings may be wrong by offsets, which are estimated; false for readings known to be exact"""
        contours: bool
        """METHOD_FULL: edges on outlines go into the pose; if false they are evidence only"""
        adaptation: bool
        """METHOD_FULL: a push of the camera is noticed and followed; false for a camera that is fixed to the arms"""
        initialWindow: float
        """half-width of the search window before the first pose [m on the tool]"""
        minWindow: float
        """smallest half-width of the search window while tracking [pixel at 720 px width]"""
        minInitialInliers: int
        """matches needed for a first pose (paper's release: more than 6); METHOD_FULL: to count as tracking at once, else five"""
        minInitialSimilarity: float
        """their least mean similarity; bare tissue gives up to 0.6, a tool 0.75 and more. Not METHOD_FULL, which has the outline too"""
        minConfidence: float
        """METHOD_FULL: what ToolEstimate.confidence a first pose must have to be worth another frame, 0..1 (default 0.5). What is asked of tracking moves with it, in odds: more of it starts and goes on less readily, and is wrong less often. 0: no pose is refused, the caller judges"""
        confirmFrames: int
        """frames that must confirm a first pose before it counts as tracking; METHOD_FULL needs none where the evidence is strong"""
        coastingTime: float
        """without a measurement for longer a tool is lost [s]"""
        seed: int
        """of all random choices"""

    class Stages:
        """Parameters of the stages that a tracker is made of. Pixels are those of an image 720 pixels wide. What a method or
        Params decide is overruled: wholeTool of templates (METHOD_FULL), seed and minInliers of the verifier, its zones and limits
        and contrast of the matcher (METHOD_PAPER, METHOD_EPNP), halfWindow of edges.
        """
        def __init__(self) -> None: ...
        templates: PartTemplateRenderer.Params
        matcher: QGOMatcher.Params
        verifier: GeometricContextVerifier.Params
        paperFilter: ToolPoseEKF.Params
        """METHOD_PAPER"""
        filter: ArticulatedPoseEKF.Params
        """METHOD_FULL"""
        contour: ToolContour.Params
        """METHOD_FULL"""
        edges: ContourSearch
        """METHOD_FULL"""

    @staticmethod
    def create(camera: CameraModel, params: ToolTracker.Params = ..., stages: ToolTracker.Stages = ..., renderer: Optional[MeshRenderer] = ...) -> ToolTracker:
        """camera: the left one, or the only one
        params: what is tracked, and how
        stages: how its stages work
        renderer: draws the tools, for both eyes; must not be used by anyone else meanwhile. None: MeshRenderer.createSoftware().
        The second thread of renderAhead() has a software renderer of its own
        """
        ...
    def setRightCamera(self, right: CameraModel, right_T_left: NDArray[np.float64]) -> None:
        """Makes the right eye known, for updateStereo(). Before or after addTool().

        right: its intrinsics and distortion
        right_T_left: pose of the left camera in the frame of the right one [m]. Called again, the mask of the right eye stays if its
        images have the same size
        Raises cv2.error for another method than METHOD_FULL, and a transform that is not rigid
        """
        ...
    def addTool(self, model: ToolModel, nominal_T_base: NDArray[np.float64]) -> int:
        """Adds a tool.

        model: the tool
        nominal_T_base: where the (wrong) hand-eye calibration believes the arm's base to be, in the camera frame
        Returns: index of the tool
        Raises cv2.error for a tool with too few keypoints, parameters of stages that are wrong, and a transform that is not rigid or
        further away than 1000 m; no tool is then added
        """
        ...
    def update(self, image: NDArray[Any], time: float, joints: _Sequence[Union[_Sequence[float], NDArray[np.float64]]]) -> Tuple[ToolEstimate, ...]:
        """Tracks one frame.

        image: CV_8UC1 or CV_8UC3 (BGR) of the camera's size
        time: time stamp [s], larger than the last one
        joints: per tool, in the order of addTool(), one reading per coordinate [rad or m]
        estimates: per tool the answer
        Readings that no joint can have are left out, see ToolEstimate.skippedReadings.
        Raises cv2.error for another image type or size, another number of joints, or non-finite values. Whatever is thrown, also by a
        renderer of the user's own, the tracker is then as it was before the call
        """
        ...
    def updateStereo(self, left: NDArray[Any], right: NDArray[Any], time: float, joints: _Sequence[Union[_Sequence[float], NDArray[np.float64]]]) -> Tuple[ToolEstimate, ...]:
        """Tracks one frame of both eyes, taken at the same time; setRightCamera() comes first. Frames of one eye, by update(), may
        lie between. Poses, matches and the search for a first pose are those of the left eye.

        left, right: images of the same type, each of its camera's size
        time, joints, estimates: see update(), also for what is thrown
        """
        ...
    def renderAhead(self, joints: _Sequence[Union[_Sequence[float], NDArray[np.float64]]]) -> None:
        """Starts drawing templates in a second thread (paper, Sec. 2: two threads) and returns at once.

        A video is tracked with the drawing of the next frame beside the matching of this one:

            tracker->renderAhead(joints of frame t + 1);
            tracker->update(image t, time t, joints of frame t, estimates);

        and a live image with the newest readings as soon as there are some, before update(). Templates are drawn with the corrections
        known at the time of the call. update() knows the last request before it and the last one before the previous update(). It waits
        for the one whose drawing has the tools within a few pixels and degrees of where they are now, and moves its templates there; if
        neither has, or a tool starts or is lost, it draws as ever. The estimates so depend on the order of the calls and what is given to
        them, never on the speed of a thread; they differ a little from those without this call.

        joints: as for update(), as they are expected to be
        Raises cv2.error for another number of joints or non-finite values. What goes wrong in the second thread is thrown by the
        update() that asks for the templates, this or the next one; the tracker's state is then unchanged, and the request gone
        """
        ...
    def replaceTool(self, tool: int, model: ToolModel) -> None:
        """Another instrument is on the arm. What was learnt of the calibration stays and is where the search begins; offsets of
        joints, which are the instrument's, are forgotten. Makes the drawing of all tools anew: some milliseconds and more for a large CAD.

        tool: index, stays the same
        model: the new one
        """
        ...
    def removeTool(self, tool: int) -> None:
        """A tool is gone.

        tool: index; those of the tools after it fall by one
        """
        ...
    def setMask(self, mask: NDArray[Any], eye: int = ...) -> None:
        """Where a camera shows anything. Black surrounds are found without; overlays of a console are not.

        mask: CV_8UC1 of the images' size, 0 where there is nothing of the scene; empty: anywhere
        eye: 0 = left, 1 = right
        """
        ...
    def setHandEye(self, tool: int, nominal_T_base: NDArray[np.float64]) -> None:
        """There is another hand-eye calibration. The pose of a tool that is tracked stays as it is; one without a pose begins anew.

        tool: index
        nominal_T_base: as for addTool()
        """
        ...
    def moveCamera(self, now_T_before: NDArray[np.float64]) -> None:
        """The camera has moved since the last frame, and it is known how: a da Vinci's camera arm has joints, too. All poses, and all
        calibrations, move in its frame; the next frame goes on from there. Moves that are not told are found, too, if they are small.

        now_T_before: pose of the camera at the last frame in its frame now [m]
        """
        ...
    def readingErrors(self, tool: int) -> ReadingErrors:
        """What was learnt of the errors of a tool's joint readings, METHOD_FULL; else nothing.

        tool: index
        """
        ...
    def setReadingErrors(self, tool: int, errors: ReadingErrors) -> None:
        """The same of another day: a robot's play does not change overnight. The tool begins anew with it, also after reset().

        tool: index
        errors: of the same instrument on the same arm, see ArticulatedPoseEKF.setReadingErrors()
        Raises cv2.error for another method than METHOD_FULL, and errors of another tool
        """
        ...
    def reset(self, tool: int = ...) -> None:
        """Forgets what was learnt of a tool.

        tool: index; -1 = all
        """
        ...
    def getTimings(self) -> Tuple[StageTime, ...]:
        """Times of the stages since the first frame or the last resetTimings(), in the order of the data flow; `total` comes last."""
        ...
    def resetTimings(self) -> None:
        """Starts the times of getTimings() anew; tracking goes on as it was."""
        ...

class DrawnTool:
    """A tool as drawTools() and SceneView.draw() show it."""
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, model: ToolModel, joints: Union[_Sequence[float], NDArray[np.float64]], camera_T_base: NDArray[np.float64], color: _Sequence[float], opacity: float) -> None:
        """model: the tool
        joints: one value per coordinate [rad or m]
        camera_T_base: the arm's base in the camera frame
        color: BGR
        opacity: of its surface, 0..1
        """
        ...
    @overload
    def __init__(self, model: ToolModel, estimate: ToolEstimate, opacity: float) -> None:
        """A tool where an estimate has it: green where that is known (tracking or coasting), else grey.

        model: the tool
        estimate: what the tracker said of it
        opacity: of its surface, 0..1
        """
        ...
    model: ToolModel
    joints: NDArray[np.float64]
    """one value per coordinate [rad or m]"""
    camera_T_base: NDArray[np.float64]
    """the arm's base in the camera frame"""
    color: _Sequence[float]
    """BGR"""
    opacity: float
    """of its surface: 0 = outline only, 1 = hides the image"""

def drawTools(image: NDArray[Any], camera: CameraModel, tools: _Sequence[DrawnTool], renderer: Optional[MeshRenderer] = ..., thickness: int = ...) -> NDArray[Any]:
    """Draws tools over a camera's image where they are: their shaded surface, blended, and their outline.

    All tools are in one drawing: the nearer one hides the other. Only pixels that a tool covers are changed; the image's distortion is
    that of the camera.

    image: CV_8UC3 of the camera's size, is drawn on
    camera: of the image
    tools: their poses and looks
    renderer: keep one from image to image, and the tools' meshes are prepared once; none: a software renderer of this call's own
    thickness: of the outlines, inside of the tools [pixel]; 0 = none, negative: image width / 360
    """
    ...

def drawTool(image: NDArray[Any], camera: CameraModel, model: ToolModel, joints: NDArray[Any], camera_T_base: NDArray[np.float64], color: _Sequence[float] = ..., opacity: float = ..., renderer: Optional[MeshRenderer] = ...) -> NDArray[Any]:
    """drawTools() of a single tool.

    image: CV_8UC3 of the camera's size, is drawn on
    camera: of the image
    model: the tool
    joints: one value per coordinate [rad or m]
    camera_T_base: the arm's base in the camera frame
    color: BGR
    opacity: of its surface, 0..1
    renderer: see drawTools()
    """
    ...

def drawSkeleton(image: NDArray[Any], camera: CameraModel, model: ToolModel, joints: NDArray[Any], camera_T_base: NDArray[np.float64], color: _Sequence[float]) -> NDArray[Any]:
    """Draws a tool's skeleton (joint axes' origins and the end effector) and its keypoints into an image.

    image: CV_8UC3, is drawn on
    camera: of the image
    model: the tool
    joints: one value per coordinate [rad or m]
    camera_T_base: the arm's base in the camera frame
    color: BGR
    """
    ...

def orientationColor(bin: int) -> _Sequence[float]:
    """The colour of a quantised orientation, BGR.

    bin: 0..7
    """
    ...

def partColor(part: int) -> _Sequence[float]:
    """A colour for a part, BGR: the same in every picture, far from that of the next part.

    part: index of the keypoint
    """
    ...

def drawOrientations(image: NDArray[Any], orientations: NDArray[Any]) -> NDArray[Any]:
    """Paints quantised orientations in their colours (paper, Fig. 2b); pixels without one are left as they are.

    image: CV_8UC3, is drawn on
    orientations: CV_8UC1 bit sets of the image's size, see quantizeOrientations(); several bits are painted in the mean of their colours
    """
    ...

def drawOrientationLegend(image: NDArray[Any], centre: Tuple[int, int], radius: int) -> NDArray[Any]:
    """Draws a pie whose sectors have the colours of the gradients that point there (paper, Fig. 1c).

    image: CV_8UC3, is drawn on
    centre: of the pie [pixel]
    radius: [pixel]
    """
    ...

def drawTemplate(image: NDArray[Any], partTemplate: PartTemplate, anchor: Tuple[int, int], pixelSize: int = ...) -> NDArray[Any]:
    """Paints the features of a template in the colours of their orientations (paper, Fig. 2a).

    image: CV_8UC3, is drawn on; features beyond its border are left out
    partTemplate: the template
    anchor: where its keypoint is put [pixel]
    pixelSize: side of the squares that features are painted as [pixel]: the template is drawn this much larger
    """
    ...

def drawSimilarity(similarity: NDArray[Any], partTemplate: PartTemplate, picture: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """Paints a similarity map (paper, Fig. 2c): dark is 0, yellow is 1.

    similarity: CV_16UC1, see QGOMatcher.similarityMap()
    partTemplate: the template it is of
    picture: CV_8UC3 of the map's size
    """
    ...

def drawMatches(image: NDArray[Any], matches: _Sequence[PartMatch], filled: bool = ...) -> NDArray[Any]:
    """Draws matches as circles in their parts' colours, larger ones for more similarity, and lines to where they were expected.

    image: CV_8UC3, is drawn on
    matches: what QGOMatcher.match() or GeometricContextVerifier.verify() gave
    filled: whether the circles are
    """
    ...

def drawEvidence(image: NDArray[Any], estimate: ToolEstimate, name: str, row: int = ...) -> NDArray[Any]:
    """Draws the evidence of an estimate: its matches as dots, and a line of text in the upper left corner with the tool's name, the
    state, the similarity and how much of the outline is where it should be; green where the pose is known (tracking or coasting), else red.

    image: CV_8UC3, is drawn on
    estimate: what the tracker said
    name: of the tool
    row: of the text: 0, 1, ... for several tools in one image
    """
    ...

def drawEstimate(image: NDArray[Any], camera: CameraModel, model: ToolModel, estimate: ToolEstimate, name: str = ..., renderer: Optional[MeshRenderer] = ...) -> NDArray[Any]:
    """Draws an estimate: the tool where it was found, if that is known (tracking or coasting), and drawEvidence().

    For tools that hide each other: drawTools() of all of them, then drawEvidence() of each.

    image: CV_8UC3 of the camera's size, is drawn on
    camera: of the image
    model: the tool
    estimate: what the tracker said of it
    name: of the tool, for the text
    renderer: see drawTools()
    """
    ...

def drawGeometricContext(image: NDArray[Any], matches: _Sequence[PartMatch], inliers: _Sequence[PartMatch], sample: _Sequence[PartMatch], predicted: bool, params: GeometricContextVerifier.Params = ...) -> NDArray[Any]:
    """Draws one of the two polar grids of the geometric context (paper, Fig. 2d-f): rays and rings of the zones about the first
    match of the sample, the inliers' zones, which are those of the drawing in both grids, and the matches: inliers filled, others not.

    image: CV_8UC3, is drawn on
    matches: what was verified
    inliers: what GeometricContextVerifier.verify() gave
    sample: GeometricContextVerifier.sample(); without one, only the matches are drawn
    predicted: true: the grid of the drawing, at PartMatch.predictedPoint; false: that of the image, at PartMatch.imagePoint
    params: of the verifier
    """
    ...

def drawContour(image: NDArray[Any], points: _Sequence[ContourPoint], worst: float = ..., gain: float = ...) -> NDArray[Any]:
    """Draws what matchContour() found: the expected points, and lines along the normals to their edges, from green where the edge is
    in its place to red where it is worst pixels off. Points without an edge are grey.

    image: CV_8UC3, is drawn on
    points: after matchContour()
    worst: offset that is red [pixel]
    gain: the lines are drawn this much longer
    """
    ...

class SequenceTool:
    """One tool of a sequence."""
    def __init__(self) -> None: ...
    @property
    def name(self) -> str:
        """as in the CSV files"""
        ...
    @property
    def model(self) -> str:
        """path of the tool file"""
        ...
    @property
    def nominal_T_base(self) -> NDArray[np.float64]:
        """the calibrated, wrong, hand-eye: the key camera_T_base of the file"""
        ...
    @property
    def timeOffset(self) -> float:
        """the joints of the image of time t were recorded at t + timeOffset: the key time_offset, else 0 [s]"""
        ...

class TrueKeypoint:
    """Where a keypoint of a tool truly is in a frame."""
    def __init__(self) -> None: ...
    @property
    def name(self) -> str:
        """as in the tool file"""
        ...
    @property
    def imagePoint(self) -> Tuple[float, float]:
        """in the (distorted) left image [pixel]"""
        ...
    @property
    def cameraPoint(self) -> Tuple[float, float, float]:
        """in the left camera's frame [m]; zeros where keypoints.csv has no x, y, z"""
        ...
    @property
    def visible(self) -> bool:
        """nothing hides it"""
        ...

class Sequence:
    """A recorded sequence: a folder with sequence.yaml, video, kinematics.csv and, where known, groundtruth.csv and keypoints.csv.
    The format is described in doc/formats.md. Frame k is at time k / fps, or where frames.csv has it. Keys and columns that are not known are ignored.
    """
    @staticmethod
    def load(folder: str, recorded: bool = ...) -> Sequence:
        """Reads a sequence; videos are not opened.

        folder: the folder, or its sequence.yaml
        recorded: false: only cameras and tools are read, for live use; there need be no videos and CSV files, and asking for
        joints or truth is an error
        Raises cv2.error naming file, key or line and what was expected
        """
        ...
    def name(self) -> str:
        """The key `name`, or else the folder's name."""
        ...
    def fps(self) -> float:
        """Frames a second."""
        ...
    def frameTime(self, frame: int, field: int = ...) -> float:
        """Time of a frame: its stamp in frames.csv, interpolated between and 1 / fps apart beyond those it has; without that file
        frame / fps [s].

        frame: number, from 0 on
        field: 1: of its second field, half a frame later
        """
        ...
    def hasFrameTimes(self) -> bool:
        """Whether there is a frames.csv."""
        ...
    def leftCamera(self) -> CameraModel:
        """The left camera, or the only one."""
        ...
    def rightCamera(self) -> CameraModel:
        """The right camera; of size 0 x 0 if there is one camera."""
        ...
    def leftVideo(self) -> str:
        """Path of the left video; may lie outside the folder. Empty if not recorded and not named."""
        ...
    def rightVideo(self) -> str:
        """Path of the right video, which is the left one if both eyes are in one file; empty if there is one camera."""
        ...
    def layout(self) -> int:
        """See SequenceLayout."""
        ...
    def frameSize(self) -> Tuple[int, int]:
        """Of the frames of the videos: the cameras' size, or twice that if both eyes are in one file [pixel]."""
        ...
    def imagesPerFrame(self) -> int:
        """Images of an eye in a frame: 2 if it holds two fields, which the key `fields` tells, else 1."""
        ...
    def eyeImage(self, frame: NDArray[Any], image: Optional[NDArray[Any]] = ..., eye: int = ..., field: int = ...) -> NDArray[Any]:
        """An eye's image out of a frame of its video.

        frame: of frameSize(), CV_8UC1 or CV_8UC3
        image: of the camera's size; the frame itself, not a copy, if there is nothing to take apart
        eye: 0 = left, 1 = right
        field: 0 to imagesPerFrame() - 1, as they follow in time; see splitFields()
        """
        ...
    def mask(self, eye: int = ...) -> NDArray[Any]:
        """What of an eye's images shows the scene, for ToolTracker.setMask(): the key `mask`.

        eye: 0 = left, 1 = right
        Returns: CV_8UC1 of the camera's size, 0 where there is nothing to see; empty without the key
        Raises cv2.error naming file, key and what was expected
        """
        ...
    def right_T_left(self) -> NDArray[np.float64]:
        """Pose of the left camera in the frame of the right one [m]."""
        ...
    def isStereo(self) -> bool:
        """Whether there are two cameras."""
        ...
    def toolCount(self) -> int:
        """Number of tools."""
        ...
    def tool(self, index: int) -> SequenceTool:
        """What is known of a tool.

        index: 0 to toolCount() - 1
        """
        ...
    def jointsAt(self, tool: int, time: float, coordinates: _Sequence[str] = ...) -> Tuple[bool, NDArray[np.float64]]:
        """Joint readings at a time, linearly interpolated between the two nearest records.

        tool: index
        time: of the image [s]; SequenceTool.timeOffset is added
        joints: one value per wanted coordinate [rad or m]
        coordinates: the coordinates wanted, as ToolModel.coordinateNames(); empty = all of jointNames()
        Returns: false if the time lies outside the records (by more than one sampling interval); joints is then unchanged
        Raises cv2.error if kinematics.csv has no column for a coordinate
        """
        ...
    def jointNames(self) -> Tuple[str, ...]:
        """Names of the joint columns of kinematics.csv: all but `time` and `tool`."""
        ...
    def firstTime(self, tool: int) -> float:
        """Time of a tool's first joint reading, on the images' clock [s]."""
        ...
    def lastTime(self, tool: int) -> float:
        """Time of a tool's last joint reading, on the images' clock [s]."""
        ...
    def descriptionFile(self) -> str:
        """Path of sequence.yaml."""
        ...
    def kinematicsFile(self) -> str:
        """Path of kinematics.csv."""
        ...
    def groundTruth(self, tool: int, frame: int) -> Tuple[bool, NDArray[np.float64], NDArray[np.float64]]:
        """Ground truth of a frame.

        tool: index
        frame: number
        camera_T_tool: true pose
        joints: true joint values in the order of jointNames(); empty if the file lacks one of these columns
        Returns: false if there is none for this frame; the outputs are then unchanged
        """
        ...
    def hasGroundTruth(self) -> bool:
        """Whether the folder has a groundtruth.csv."""
        ...
    def groundTruthEnd(self) -> int:
        """One more than the last frame with ground truth; 0 without."""
        ...
    def groundTruthFile(self) -> str:
        """Path of groundtruth.csv, whether there is one or not."""
        ...
    def keypoints(self, tool: int, frame: int) -> Tuple[TrueKeypoint, ...]:
        """True places of a tool's keypoints in a frame, in the order of the file.

        tool: index
        frame: number
        Returns: empty if there are none of this frame, or no keypoints.csv
        Raises cv2.error naming file, line and what was expected; the file is read when it is first asked for
        """
        ...
    def hasKeypoints(self) -> bool:
        """Whether the folder has a keypoints.csv; it may hold no points."""
        ...
    def keypointsFile(self) -> str:
        """Path of keypoints.csv, whether there is one or not."""
        ...

class PoseWriter:
    """Writes a poses CSV: `frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw` and further columns.
    Each row is flushed, so that what was written is complete and readable whatever happens next.
    """
    @overload
    @staticmethod
    def create(filename: str, extraColumns: _Sequence[str] = ...) -> PoseWriter:
        """Begins a file.

        filename: is overwritten
        extraColumns: names of further columns
        Raises cv2.error naming the file if it can't be written
        """
        ...
    @overload
    @staticmethod
    def create(filename: str, tools: _Sequence[str], models: _Sequence[ToolModel], extraColumns: _Sequence[str] = ...) -> PoseWriter:
        """Begins a file of estimates. Its further columns are what they say beside the pose (doc/formats.md): evidence, standard
        deviations, and the offsets of the joints, those of the first tool.

        filename: is overwritten
        tools: names
        models: theirs
        extraColumns: names of columns after these
        Raises cv2.error naming the file if it can't be written
        """
        ...
    @overload
    def write(self, frame: int, time: float, tool: str, state: int, camera_T_tool: NDArray[np.float64], extra: Union[_Sequence[float], NDArray[np.float64]] = ...) -> None:
        """Adds one row.

        frame: number
        time: [s]
        tool: name
        state: see TrackingState
        camera_T_tool: rigid; a non-finite pose is an error
        extra: one value per further column; non-finite values are left empty
        Raises cv2.error naming the file if the row can't be written (as on a full disk)
        """
        ...
    @overload
    def write(self, frame: int, time: float, tool: str, estimate: ToolEstimate, extra: Union[_Sequence[float], NDArray[np.float64]] = ...) -> None:
        """Adds the row of an estimate to a file that was begun for estimates.

        frame: number
        time: [s]
        tool: name, one of those given to create()
        estimate: of this tool; values it has none of are left empty: deviations without a covariance, offsets of joints that only
        the first tool has
        extra: one value per column of `extraColumns`; non-finite values are left empty
        Raises cv2.error as above
        """
        ...

def writeSequenceCameras(folder: str, cameras: CameraPair, leftVideo: str = ..., rightVideo: str = ..., fps: float = ...) -> None:
    """Puts cameras into a folder's sequence.yaml, which is made if it does not exist; all else in it is kept, but for comments.

    folder: of the sequence; is made if it does not exist
    cameras: one eye or two
    leftVideo: path for the key `left.video`; empty: that stays as it is, or `left.mp4`
    rightVideo: the same of the right eye
    fps: frames per second; 0: stays as it is, or is missing
    """
    ...

def writeSequenceTool(folder: str, name: str, model: str, nominal_T_base: NDArray[np.float64]) -> None:
    """Puts a tool into a folder's sequence.yaml, in the place of the one of this name, or at the end.

    folder: of the sequence; is made if it does not exist
    name: as in the CSV files
    model: path of the tool file, for the key `model`; empty: stays as it is
    nominal_T_base: the hand-eye calibration, key `camera_T_base`
    """
    ...

def writeSequenceJoints(folder: str, name: str, coordinates: _Sequence[str], times: Union[_Sequence[float], NDArray[np.float64]], joints: NDArray[Any]) -> None:
    """Puts a tool's joint readings into a folder's kinematics.csv, in the place of those of this name.

    folder: of the sequence; is made if it does not exist
    name: of the tool
    coordinates: names of the columns; other tools in the file must have the same
    times: rising, on the clock on which frame k is at k / fps [s]
    joints: N x C CV_64F, a row a time [rad or m]
    """
    ...

def writeHandEye(sequence: str, tool: str, camera_T_base: NDArray[np.float64]) -> None:
    """Sets a tool's `camera_T_base` in a sequence.yaml. The rest of the file stays as it is, to the byte; the new file takes the
    place of the old one at once.

    sequence: the folder, or its sequence.yaml
    tool: name
    camera_T_base: rigid [m]
    Raises cv2.error naming file and key: not a description as in doc/formats.md, no such tool, can't be written
    """
    ...

def readPoses(filename: str, poses: Optional[NDArray[Any]] = ...) -> Tuple[bool, NDArray[np.float64], NDArray[Any]]:
    """Reads rigid poses from a CSV file with the columns `index` or `time`, and tx, ty, tz [m], qx, qy, qz, qw.

    filename: the file
    keys: values of the first of these columns, rising [s if it is `time`]
    poses: N x 16 CV_64F: 4 x 4 matrices, row by row
    Returns: whether the column is `time`
    Raises cv2.error naming file and line
    """
    ...

class SyntheticScene:
    """A synthetic scene with exact truth: tools moving over textured tissue, seen by an endoscope.

    The built-in sequence of tests and demonstration. Tools are lit by the endoscope's own light; the image has vignette,
    noise and, if the camera has it, distortion. The recorded joints carry bias, drift and noise, and the recorded hand-eye
    calibration is wrong. Everything follows from the seed.
    """
    class Params:
        def __init__(self) -> None: ...
        tools: int
        """1..4"""
        frames: int
        """length; the motion is periodic in it"""
        seed: int
        imageSize: Tuple[int, int]
        """[pixel]; write() needs an even width and height"""
        fps: float
        handEyeRotation: float
        """error of the recorded hand-eye calibration [rad]"""
        handEyeTranslation: float
        """the same [m], at the tool"""
        jointNoise: float
        """scale of offsets and noise of the joints: 1 = 0.006 rad and 0.6 mm at the arm, 0.02 rad at the wrist, 0.03 rad at the jaw; 0 = none"""
        cables: float
        """scale of what the cables of wrist and jaws add: 1 = as measured on a real arm, play of 0.02 rad, gains of 2 %, a coupling of pitch into yaw of 0.09; 0 (default) = nothing"""
        imageNoise: float
        """standard deviation of the sensor noise [grey levels]"""
        distortion: bool
        """lens distortion (k1 = -0.2) or a pinhole"""
        stereo: bool
        """a right image, 5.2 mm beside the left one"""

    @staticmethod
    def create(model: Optional[ToolModel] = ..., params: SyntheticScene.Params = ...) -> SyntheticScene:
        """A scene from its seed.

        model: the tool all arms carry; empty = ToolModel.needleDriver(); an arm of two joints that turn, one that slides, one that rolls, two of
        a wrist, and perhaps one of jaws
        params: options
        """
        ...
    def toolCount(self) -> int:
        """Number of arms."""
        ...
    def frameCount(self) -> int:
        """Params.frames."""
        ...
    def model(self) -> ToolModel:
        """The tool that all arms carry."""
        ...
    def camera(self, right: bool = ...) -> CameraModel:
        """One of the cameras.

        right: the right one of a stereo scene
        """
        ...
    def right_T_left(self) -> NDArray[np.float64]:
        """Pose of the left camera in the frame of the right one [m]."""
        ...
    def nominal_T_base(self, tool: int) -> NDArray[np.float64]:
        """The recorded, wrong, hand-eye calibration of an arm."""
        ...
    def camera_T_base(self, tool: int) -> NDArray[np.float64]:
        """The true hand-eye calibration of an arm (left camera)."""
        ...
    def trueJoints(self, tool: int, time: float) -> NDArray[np.float64]:
        """True joints at a time [s]: one value per coordinate [rad or m]."""
        ...
    def recordedJoints(self, tool: int, time: float) -> NDArray[np.float64]:
        """Joints at a time [s] as the robot reads them: one value per coordinate [rad or m]."""
        ...
    def truePose(self, tool: int, time: float) -> NDArray[np.float64]:
        """camera_T_tool, exact (left camera).

        tool: index
        time: [s]
        """
        ...
    def render(self, frame: int, image: Optional[NDArray[Any]] = ..., right: bool = ...) -> NDArray[Any]:
        """Draws a frame.

        frame: number, 0 <= frame
        image: CV_8UC3, BGR
        right: the right eye of a stereo scene
        """
        ...
    def renderArms(self, frame: int, joints: _Sequence[Union[_Sequence[float], NDArray[np.float64]]], camera_T_base: Union[_Sequence[NDArray[np.float64]], NDArray[np.float64]], image: Optional[NDArray[Any]] = ..., right: bool = ...) -> NDArray[Any]:
        """Draws a frame with arms that stand or move otherwise: as after a knock against the camera, or with one more arm.

        frame: number, 0 <= frame; decides the sensor noise
        joints: per arm the true joints, one value per coordinate [rad or m]; any number of arms
        camera_T_base: per arm its base (left camera)
        image: CV_8UC3, BGR
        right: the right eye of a stereo scene
        Raises cv2.error for vectors of different lengths, and for more links than a MeshRenderer can tell apart
        """
        ...
    def write(self, folder: str) -> None:
        """Writes the scene as a sequence folder: sequence.yaml, video, kinematics.csv (100 Hz), groundtruth.csv,
        keypoints.csv, and the tool file with its meshes.

        folder: is made if it does not exist
        Raises cv2.error naming the file that can't be written
        """
        ...

def handEyeMethodName(method: int) -> str:
    """`tsai`, `park`, ..., `refined`; `best` for HAND_EYE_BEST."""
    ...

class HandEyeParams:
    """Options of estimateHandEye()."""
    def __init__(self) -> None: ...
    setup: int
    """see HandEyeSetup; default HAND_EYE_BOARD_ON_TOOL, the paper's"""
    method: int
    """see HandEyeMethod; default HAND_EYE_BEST"""
    rejection: float
    """a pose is thrown out if its error is so many standard deviations; default 3, 0 = keep all"""
    seed: int
    """of all random choices"""

class HandEyeFit:
    """What one method found. Errors are root mean squares over the poses that were not thrown out."""
    def __init__(self) -> None: ...
    @property
    def method(self) -> int:
        """see HandEyeMethod"""
        ...
    @property
    def valid(self) -> bool:
        """false: it has no finite answer, or none if a pose is left out; all else is then 0"""
        ...
    @property
    def camera_T_mount(self) -> NDArray[np.float64]:
        """the calibration. HAND_EYE_BOARD_ON_TOOL: camera_T_base"""
        ...
    @property
    def holder_T_board(self) -> NDArray[np.float64]:
        """where the board is"""
        ...
    @property
    def translation(self) -> float:
        """error of the middle of the board [m]"""
        ...
    @property
    def rotation(self) -> float:
        """error of the board's orientation [rad]"""
        ...
    @property
    def pixels(self) -> float:
        """error of the board's points in the image [pixel]; 0 without a camera"""
        ...
    @property
    def leftOutTranslation(self) -> float:
        """the same, of each pose by the calibration from all the others [m]"""
        ...
    @property
    def leftOutRotation(self) -> float:
        """[rad]"""
        ...
    @property
    def leftOutPixels(self) -> float:
        """[pixel]"""
        ...
    @property
    def spreadTranslation(self) -> float:
        """standard deviation of the calibration where the board was, from those without a pose each (jackknife) [m]"""
        ...
    @property
    def spreadRotation(self) -> float:
        """standard deviation of its rotation, likewise [rad]"""
        ...

class HandEyeResult:
    """The answer of estimateHandEye()."""
    def __init__(self) -> None: ...
    @property
    def best(self) -> HandEyeFit:
        """the calibration to use"""
        ...
    @property
    def fits(self) -> Tuple[HandEyeFit, ...]:
        """all methods, in the order of HandEyeMethod"""
        ...
    @property
    def rejected(self) -> NDArray[Any]:
        """indices of the poses that were thrown out, rising"""
        ...
    @property
    def residuals(self) -> NDArray[Any]:
        """N x 3 CV_64F, of `best`, of all poses: [m], [rad], [pixel]"""
        ...
    @property
    def largestRotation(self) -> float:
        """between any two poses that were kept [rad]"""
        ...
    @property
    def crossRotation(self) -> float:
        """the same, about axes perpendicular to the one they turn about most [rad]"""
        ...
    @property
    def warnings(self) -> Tuple[str, ...]:
        """too little motion, an uncertain result: one line each"""
        ...
    @property
    def reason(self) -> str:
        """why the calibration can't be told, one line; empty if it can"""
        ...

def estimateHandEye(robotPoses: NDArray[Any], boardPoses: NDArray[Any], params: HandEyeParams = ..., camera: CameraModel = ..., boardPoints: NDArray[Any] = ...) -> Tuple[bool, HandEyeResult]:
    """Hand-eye calibration: the camera against the robot, from poses of robot and board.

    Every method is run. Poses that do not fit the others are thrown out first: from the least median of squares over random quadruples,
    then repeatedly those whose error, as predicted from the others, is more than HandEyeParams.rejection standard deviations (root mean
    square of three translations and three rotations). With less than six poses none is. The standard deviations, along the line of
    sight and across, are taken from the medians of these errors. Each pose is then left out once, of more than 30 poses every
    thirtieth, and predicted from the others: the method with the smallest of these errors, in standard deviations, is the best.
    The methods look at all pairs of poses: 20 poses take half a second, 100 half a minute.

    robotPoses: N poses, N x 4 x 4 (or N x 16), floating, rigid [m], N from 4 to 200: HAND_EYE_BOARD_ON_TOOL base_T_tool, HAND_EYE_CAMERA_ON_ARM
    base_T_arm of the arm that holds the camera
    boardPoses: as many poses camera_T_board, as findBoard() gives them
    result: after false `best` must not be relied on, and `reason` says why
    params: options
    camera: to report errors in pixels too; an empty one = not
    boardPoints: N x 3 points of the board, in its frame [m], see getBoardPoints(). Without them the corners of a square of 15 mm,
    with the frame's origin in the middle
    Returns: whether the calibration can be told. It can't be from poses that all turn about the same axis
    Raises cv2.error naming the argument, and the pose, if it is not valid
    """
    ...

class CalibrationBoard:
    """A flat calibration board. Both kinds look different upside down, so that poses from several images belong together."""
    def __init__(self) -> None: ...
    pattern: int
    """default ASYMMETRIC_CIRCLES, the paper's"""
    size: Tuple[int, int]
    """inner corners of a chessboard, one of the numbers odd and one even; circles a row and rows, an odd number of rows; default 4 x 11, the paper's"""
    spacing: float
    """side of a square; distance of two rows of circles, half of that of two circles in a row [m]; default 0.0015, the paper's"""

def getBoardPoints(board: CalibrationBoard, points: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """Points of a board, in the order of cv2.findChessboardCorners() and cv2.findCirclesGrid().

    board: the board
    points: N x 3 CV_64F, z = 0 [m]
    Raises cv2.error if the board is not one of those CalibrationBoard describes
    """
    ...

def findBoard(image: NDArray[Any], camera: CameraModel, board: CalibrationBoard, imagePoints: Optional[NDArray[Any]] = ...) -> Tuple[bool, NDArray[np.float64], NDArray[Any], float]:
    """Finds a board in an image and its pose, with the camera's distortion.

    image: as the camera delivers it, CV_8UC1 or CV_8UC3, of the camera's image size
    camera: the camera
    board: the board
    camera_T_board: its pose [m]
    imagePoints: N x 2 CV_64F, where its points were found [pixel]
    error: root mean square distance of the points found from those of the pose [pixel]
    Returns: false if the board was not found; the outputs are then unchanged
    """
    ...

class TimeOffsetParams:
    """Options of estimateTimeOffset()."""
    def __init__(self) -> None: ...
    expected: float
    """centre of the search [s]; default 0"""
    range: float
    """offsets this far from the expected one are searched [s]; default 3"""
    step: float
    """of the first, coarse search [s]; default 0.16. A tool should move by less than 10 mm in it"""
    frames: int
    """at most so many frames are looked at, spread over the sequence; default 48"""
    minOverlap: float
    """offsets that leave less of the video with readings are not considered [s]; default 1.5"""
    minConfidence: float
    """see TimeOffset.confidence; default 0.15"""
    maxDeviation: float
    """see TimeOffset.deviation [s]; default 0.03"""
    seed: int
    """of all random choices"""
    tool: int
    """index of the only tool that is looked at, as arms may have clocks of their own; -1, the default: one offset holds for all"""

class TimeOffset:
    """The answer of estimateTimeOffset()."""
    def __init__(self) -> None: ...
    @property
    def offset(self) -> float:
        """the readings that belong to the image of time t are those recorded at t + offset [s]"""
        ...
    @property
    def deviation(self) -> float:
        """standard deviation of the offset, if it is the right one and not another that looks alike [s]"""
        ...
    @property
    def confidence(self) -> float:
        """0..1: by how much the images support this offset more than the next best that is not a neighbour; 0.5 = twice as much"""
        ...
    @property
    def support(self) -> float:
        """summed similarity above chance of the parts found where the offset has them, a frame and tool"""
        ...
    @property
    def frames(self) -> int:
        """frames in which a tool was found"""
        ...
    @property
    def reason(self) -> str:
        """why the offset can't be told, one line; empty if it can"""
        ...

def estimateTimeOffset(sequence: Sequence, params: TimeOffsetParams = ...) -> Tuple[bool, TimeOffset]:
    """Finds by how much the clocks of video and joint readings differ, from the whole of a recorded sequence.

    The tools are drawn as the readings of many times say they look, and sought in frames spread over the video. Of each offset, in
    coarse steps, the similarity of what was found tells how well it is supported. The best few are refined to a fraction of a frame:
    one least-squares fit, over all frames, of the offset (a point is wrong by its velocity times the error of the offset), of the
    correction of the hand-eye calibration and of constant errors of the joints; then tools are drawn and found again with the result.
    The correction may change from one two-second block to the next where the images insist, as after a move of the camera.

    Expects a calibration wrong by at most 14 mm at the tool and about 10 degrees. One offset holds for the whole sequence.
    With the default options it takes about 15 s for two tools at 720x576, in proportion to frames, tools and range. The frames looked at
    are kept in memory.

    sequence: video (the left one) and readings
    result: after false `offset` is the best guess and must not be relied on, and `reason` says why
    params: options
    Returns: whether the offset is known: Params.minConfidence and Params.maxDeviation are met. It can't be known if tools hardly move
    or are hardly seen, if too little of the video has readings, if the motion repeats itself within the range, or if the offset lies outside of it
    Raises cv2.error for options out of range and naming the file if the video can't be read or has frames of another size
    """
    ...

class ToolParts:
    """What the kinematics of a robot do not say of a tool: its shape, and the points to look for."""
    def __init__(self) -> None: ...
    like: str
    """A tool file to take meshes, keypoints, jaws and the place of the end effector from, for a tool of the same build; empty: none.
    Of a dVRK tool it also gives the names of links and coordinates, joint for joint; links of an URDF are found by their names.
    """
    meshes: Tuple[str, ...]
    """`LINK:FILE` each: mesh files (PLY, STL or OBJ) of links; they replace those of the file imported, or of `like`,
    which are not read. `LINK:none`: that link has no mesh.
    """
    meshScale: float
    """of the files in `meshes`: metres per unit; 1 = metres, 0.001 = millimetres"""
    meshesInToolAxes: bool
    """The axes of `meshes` are those of the reported tool frame (the rotation of `tooltip_offset`), as in jhu-dvrk/dvrk_model, and not
    those of the Denavit-Hartenberg frame of their link. Their origin is the link's in both cases. dVRK tools only.
    """
    keypoints: str
    """A CSV file `name,link,x,y,z`: keypoints as they are picked in the link's mesh file, in its axes and unit (of an URDF: before the visual's scale
    and origin); they replace those of `like`, and may be 2 mm off the link's surface at most. `auto` or `auto:N`: chooseKeypoints() chooses.
    Empty: those of `like`, else none.
    """
    packages: str
    """URDF: the folder in which `package://NAME/...` is looked for, as NAME/... or as ...; empty: the URDF's, and those above it"""
    base: str
    """URDF: the link to take for the arm's base, the remote centre of motion; empty: the root"""
    endEffector: str
    """URDF: the link to report the pose of; empty: as in `like`, else `tool_tip_link`, else the only end that no joint moves by itself"""

def importDvrkTool(files: _Sequence[str], parts: ToolParts = ...) -> ToolModel:
    """A tool from the kinematics of the da Vinci Research Kit, arm and instrument.

    Reads files as sawIntuitiveResearchKit has them, comments included: `DH.joints` (or, in old files, `DH.links`), modified convention;
    `tooltip_offset` (old: `tooltip-offset`); `jaw`. `theta + offset + q` turns, `D + offset + q` slides. As the dVRK does, angles that
    are a multiple of pi / 12 rounded to four digits (1.5708) are made exact. Coordinates are `q1`, `q2`, ..., and `jaw` if a file has
    one: two jaws that open by half of it each, `jaw_right` and `jaw_left`.

    The end effector has the rotation of `tooltip_offset`. Its origin is that of `tooltip_offset`; where that is at 0, as the dVRK ships it,
    and ToolParts.like is given, it is where that tool has it.

    files: the kinematic files in the order of the joints: the arm's (PSM.json), the instrument's (LARGE_NEEDLE_DRIVER_400006.json);
    or one old file with all. Joints of mode `passive` do not move
    parts: meshes and keypoints; without any the tool has kinematics only
    Raises cv2.error (StsNotImplemented) if the module was built without nlohmann_json
    """
    ...

def importUrdfTool(filename: str, parts: ToolParts = ...) -> ToolModel:
    """A tool from an expanded URDF (no xacro).

    Joints that turn or slide become coordinates of the same name; joints that mimic share the coordinate of the joint they follow. A
    joint in a general place takes up to four links of modified Denavit-Hartenberg transforms; the last has the name of the URDF's link.
    Coordinates come in the order of the joints on the way to the end effector, from the base on, then the others as in the file.
    The visuals of a link are read, with their scale and origin: meshes, cylinders, spheres and boxes; those of the base are not, it does not move with the tool.
    Limits of joints are kept.
    Rotations by quarter turns about the axes whose angles were rounded (1.5708, 1.570796327) are made exact.

    filename: the URDF
    parts: ToolParts.packages for `package://` names; keypoints and end effector
    Raises cv2.error (StsNotImplemented) if the module was built without urdfdom
    """
    ...

def importCameraInfo(files: _Sequence[str]) -> CameraPair:
    """Cameras from ROS calibration files (`camera_info` YAML, as camera_calibration writes them), or CameraInfo messages as `ros2 topic
    echo` prints them. Without a region of interest images are of the whole sensor.

    files: the left camera's, or left and right of a stereo pair (its baseline is in the `projection_matrix`, in metres)
    Raises cv2.error for distortion models other than plumb_bob and rational_polynomial, and cameras more than 0.5 m apart
    """
    ...

def importOpenCVCameras(files: _Sequence[str], unit: float = ..., imageSize: Tuple[int, int] = ...) -> CameraPair:
    """Cameras from files of cv2.FileStorage.

    Keys are those of OpenCV's samples and common elsewhere: `M1, D1, M2, D2, R, T` (intrinsics.yml and extrinsics.yml),
    `cameraMatrix1, distCoeffs1, ...`, `camera_matrix, distortion_coefficients` (`Camera_Matrix, Distortion_Coefficients`). Calibrations of
    fisheye lenses are refused.

    files: one or several, taken together
    unit: metres per unit of T (0.001 for a board measured in millimetres); needed with two eyes, as files do not say it
    imageSize: [pixel]; empty: the file has to have it (`image_width`, `image_height` or `imageSize`)
    """
    ...

def importSurgPoseCameras(filename: str) -> CameraPair:
    """Cameras from SurgPose's StereoCalibrationDVRK.ini: `kc_0, kc_1, kc_4` radial, `kc_2, kc_3` tangential; T in millimetres."""
    ...

def importHandEye(filename: str) -> NDArray[np.float64]:
    """A hand-eye calibration from a file of others.

    filename: of cv2.FileStorage, plain YAML or JSON: `camera_T_base`; the dVRK's `...-registration-open-cv.json`: `base-frame.transform`;
    or a text of three or four lines of four numbers
    Returns: camera_T_base [m]
    """
    ...

def importJoints(files: _Sequence[str], coordinates: _Sequence[str], joints: Optional[NDArray[Any]] = ..., columns: _Sequence[str] = ...) -> Tuple[NDArray[np.float64], NDArray[Any]]:
    """Joint readings from CSV files of dVRK or ROS recordings.

    The time is the column `...header.stamp`, `...stamp`, `time` (`Time`, `time_ms`, `time [ns]`), `__time`, `%time` or `t`, or the pair `...secs`
    and `...nsecs` (`...sec`, `...nanosec`); the first of these in which the time does not stand still. Seconds or nanoseconds are told by the
    rate, which must lie between 2 Hz and 5 kHz, if the name has no unit; dates of ISO 8601 are seconds since 1970. Joints are the columns of the
    coordinate's name, of the dVRK's (`yaw` or `outer_yaw` for q1, ... `jaw`), perhaps followed by `position` or a unit (`q1 [deg]`,
    `insertion_mm`); those whose names stand in the rows (`name0` of `position0`, or lists `name` and `position`); or, in a file with none of
    these, `...position0`, `...position[1]`, ..., in the order of the coordinates, going on from file to file. A cell that is empty or
    `nan` has no reading: each joint is interpolated over those it has.

    files: the arm's, and if the jaw was recorded apart, the jaw's: interpolated to the times of the first
    coordinates: names, as ToolModel.coordinateNames()
    times: of the readings, on the recording's own clock [s]
    joints: N x C CV_64F, a row a time [rad or m]
    columns: the column of each coordinate, with its unit if that is in the name (`a [deg]`), if the names are others; empty: as above
    Raises cv2.error too if a joint of the dVRK slides further than 10 m or turns more than twice: other units
    """
    ...

def importSurgPoseJoints(filename: str, arm: str, coordinates: int, jaw: float, joints: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """Joint values of SurgPose (api_jp_data.yaml): of each frame, from 0 on, six of each arm.

    filename: the YAML
    arm: `PSM1` or `PSM3`
    coordinates: of the tool, 7
    jaw: the last one, which the recording has not [rad]
    joints: N x coordinates CV_64F, a row a frame [rad or m]
    """
    ...

def importDaVinciJoints(filename: str, model: ToolModel, joints: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """Joint values from the poses recorded by the authors of [ye2016realtime] (`sim-PSM1-....xml` of daVinciToolTrack, millimetres).

    The poses of the links of the coordinates q4, q5 and q6 are known; joints are found by Gauss-Newton steps, turns without jumps. The jaw
    is clamped at closed.

    filename: the XML
    model: the tool: six joints to the end effector, and a coordinate for the jaw
    joints: N x 7 CV_64F, a row a frame, in the order of the model's coordinates [rad or m]
    Raises cv2.error too if a pose is more than 1 mm or 0.02 rad from any the model can take (the three poses of a frame were read one
    after the other: in fast motion they disagree by up to 0.17 mm and 5e-3 rad)
    """
    ...

def importDaVinciHandEye(filename: str, key: str) -> NDArray[np.float64]:
    """Hand-eye calibration of the same authors (`out_handeye_data.xml`, millimetres).

    filename: the XML
    key: `bHc_psm1` or `bHc_psm2`
    Returns: nominal_T_base, the base in the camera's frame [m]
    """
    ...

def importEndoVisKeypoints(labels: str, csv: str, keypoints: _Sequence[str] = ..., tools: _Sequence[str] = ...) -> int:
    """Writes keypoints.csv from the labels of the EndoVis 2015 challenge (JSON: a list of images).

    labels: the JSON; the frame is the number in an entry's `filename`, counted from that of the first entry; without numbers entry k is frame k. A
    label without `id`, as some of the test set are, is of the only tool of its image without a label of that class; else it is left out
    csv: the file to write
    keypoints: `CLASS:NAME` each: label classes to write and the names of the tool's keypoints they are; empty: all, by their class
    tools: `ID:NAME` each, the same for tools
    Returns: number of points
    Raises cv2.error (StsNotImplemented) if the module was built without nlohmann_json
    """
    ...

def importSurgPoseKeypoints(labels: str, csv: str, keypoints: _Sequence[str] = ..., tools: _Sequence[str] = ...) -> int:
    """Writes keypoints.csv from the labels of SurgPose (keypoints_left.yaml). Keypoints 1 to 7 are those of PSM1, 8 to 14 of PSM3.

    labels: the YAML
    csv: the file to write
    keypoints: `NUMBER:NAME` each, the number as in the file; empty: all, by their number
    tools: `PSM1:NAME` and `PSM3:NAME`; empty: both, by these names
    Returns: number of points
    """
    ...

class JointReading:
    """What a robot says of one tool's joints at one moment: of all of them, or of some."""
    def __init__(self) -> None: ...
    tool: str
    """empty if the sender does not say"""
    time: float
    """on the robot's clock [s]"""
    names: Tuple[str, ...]
    """of the positions; empty if the sender does not say"""
    positions: NDArray[np.float64]
    """[rad or m]"""

def parseJointMessage(message: str) -> Tuple[JointReading, ...]:
    """Reads a message of a robot. Two kinds are understood:

        {"tool": "PSM1", "time": 12.34, "position": [0.1, -0.2, 0.12, 0.3, 0.2, -0.1, 0.5]}
        {"measured_js": {"Name": ["yaw", "pitch", ...], "Position": [0.1, -0.2, ...], "Timestamp": 12.34, "Valid": true, ...}}

    The first is plain: `tool` may be missing, names come as `"name": ["q1", ...]` or as `"position": {"q1": 0.1, ...}`. The second is
    that of the dVRK's sawSocketStreamer, which has one such key in a message, or several. A key is `measured_js`, before it the tool's
    name or nothing, and `jaw` for the jaw: `PSM1/measured_js`, `jaw/measured_js`, `PSM1/jaw/measured_js`. What a jaw's joint is called
    there does not matter, here it is `jaw`. Readings the robot says are not valid are left out, and so are other keys.

    message: JSON
    readings: those it has; none in a message about other things
    Raises cv2.error naming the key and what was expected, of text that is not JSON, and of a reading that lacks a key or has
    another type, number of values, or a value that is not finite, a time beyond 1e11 s or a position beyond 1e6; readings is then empty. Also if the module was built without
    nlohmann_json
    """
    ...

def formatPoseMessage(frame: int, time: float, tool: str, estimate: ToolEstimate) -> str:
    """Writes an estimate as a line of JSON, for sending.

    frame: number
    time: of the image [s]
    tool: name
    estimate: its numbers must be finite
    Returns: `frame`, `time`, `tool`, `status` (see stateName()), `position` [m] and `orientation` (unit quaternion x, y, z, w) of
    camera_T_tool, `covariance` (6 rows of 6 numbers, as ToolEstimate.covariance), `joint_offsets`, `similarity`, `contour`,
    `inliers`, `nis`; all numbers but the time with nine digits
    Raises cv2.error if a number is not finite, or the module was built without nlohmann_json
    """
    ...

class JointBuffer:
    """The joint readings of a tool's last seconds, to be had at the time of an image. For readings that come one by one, in
    any order and from several senders, as over a network: late ones are put where they belong, those there is one of already are
    ignored. Each coordinate has a history of its own, since arm and jaws are read at different moments. Not for several threads at
    once.
    """
    @staticmethod
    def create(coordinates: _Sequence[str], history: float = ..., maxGap: float = ...) -> JointBuffer:
        """coordinates: as ToolModel.coordinateNames()
        history: how long a reading is kept [s]; 4096 readings of a coordinate at most
        maxGap: readings further apart are not interpolated between [s]. A tool at 50 mm/s that turns back within 0.1 s is
        1.3 mm off a straight line
        """
        ...
    def add(self, reading: JointReading) -> bool:
        """Takes in a reading.

        Positions go to the coordinates of their names, or of those the dVRK has for q1 to q6 (yaw, pitch, insertion, roll, wrist_pitch,
        wrist_yaw, with or without `outer_`); a name that is none is passed over. Without names, or if none of them is a
        coordinate, positions are in the order of the coordinates: all of them, or all but the last one, the jaw.

        A reading older than the history, counted from the newest one, is not kept, nor one that is newer by more than that. If that happens 50
        times in succession the robot's clock was set, or paused, or the newest reading was wrong: the history then starts anew.

        Returns: whether anything of it was new
        Raises cv2.error for another number of positions, for values that are not finite, and for times beyond 1e11 s and positions beyond
        1e6, which no robot has; nothing is then kept
        """
        ...
    def at(self, time: float) -> Tuple[int, NDArray[np.float64]]:
        """The joints at a time, linearly interpolated.

        time: on the robot's clock [s]
        joints: one value per coordinate [rad or m]; unchanged if there are none
        Returns: see JointsState; of several coordinates that of the first one that is not found
        """
        ...
    def newest(self) -> float:
        """The last moment of which all coordinates are known [s]; -DBL_MAX if there is none."""
        ...
    def clear(self) -> None:
        """Forgets all readings."""
        ...

class ClockOffset:
    """How far another clock is behind this one, from messages stamped by that one. A message takes some time to arrive, never
    less than none, so the one that arrived soonest after its stamp tells best; of those of the last seconds, since clocks drift.
    """
    @staticmethod
    def create(window: float = ...) -> ClockOffset:
        """window: length of the time that is looked back on [s]"""
        ...
    def add(self, stamp: float, arrival: float) -> None:
        """stamp: of the message, on the sender's clock [s]
        arrival: on this clock [s], not before that of the last call
        Raises cv2.error for values that are not finite
        """
        ...
    def offset(self) -> float:
        """What to add to a time of the sender's clock to have it on this one [s]: the least arrival - stamp. 0 without a message."""
        ...

def chooseKeypoints(model: ToolModel, count: int = ...) -> ToolModel:
    """Chooses keypoints of a tool by what tracking does with them.

    Points all over the surface of wrist, jaws and the end of the shaft are tried: the tool is drawn from all around, at many settings of
    its joints, over tissue and in a light of its own. In each of these pictures PartTemplateRenderer cuts their templates from a drawing that is
    wrong by what a hand-eye calibration and a wrist are wrong by, and QGOMatcher looks for them. What a point is worth there is how much finding it,
    with the error it was found with, tells of the pose and of the offsets of wrist and jaws. Those that tell most together are taken, one by one
    (the determinant of the information matrix, over all pictures); further ones, until at least six are found from every side that shows as many.

    Takes a second or two. The same tool gets the same points.

    model: the tool; keypoints it has are replaced
    count: at least so many, if the surface has them
    Returns: the tool with keypoints named LINK_1, LINK_2, ...; their score is the share of pictures that show them in which they were found
    Raises cv2.error if the tool has no meshes, and (StsObjectNotFound) if less than four keypoints are found again
    """
    ...

def loadTool(filename: str, maxTriangles: int = ...) -> ToolModel:
    """A tool from any file that describes one: a tool file, or an URDF (by its name, `.urdf`); ready to be tracked.

    A tool without keypoints gets those of chooseKeypoints(), if there are any. The end effector of an URDF is the link `tool_tip_link`, or the only end of the
    chain that no joint moves by itself; importUrdfTool() has more options.

    filename: tool file or URDF
    maxTriangles: a tool with more triangles than this is decimated, all meshes to the same closeness; 0 = never
    """
    ...

def checkTool(model: ToolModel) -> Tuple[str, ...]:
    """What is likely to be wrong with a tool, in a line each: its chain, units and sizes, keypoints off the surface, joint limits, axes.

    model: the tool
    Returns: empty if nothing was found
    """
    ...

def drawToolSheet(model: ToolModel, sheet: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
    """Draws what a person checks an import by: the tool from six sides (columns) at three settings of its joints (rows), its keypoints
    numbered, the axes of its end effector, and the coordinates' values.

    model: the tool
    sheet: CV_8UC3, is made
    """
    ...

class SceneView:
    """A view of camera, image and tools from outside, by VTK / OpenGL.

    It shows the camera's axes (x red, y green, z blue) and its field of view up to a plane behind the tools, with the image on it, undistorted
    by being drawn where its pixels look; the tools; and paths, such as those of their tips. Everything is in the camera frame.
    """
    @staticmethod
    def create(camera: CameraModel, size: Tuple[int, int] = ..., window: bool = ...) -> SceneView:
        """camera: whose frame and image it is
        size: of the pictures [pixel]
        window: false: off screen, through an X server if DISPLAY names one, else X-free through EGL; true: in a window for show()
        Raises cv2.error (StsNotImplemented) if there is neither; with a window, if there is no display
        """
        ...
    def setViewpoint(self, viewer: Tuple[float, float, float], centre: Tuple[float, float, float]) -> None:
        """Where the scene is seen from; by default from behind, above and right of the camera, so that the tools of the first draw() are
        in the middle.

        viewer: where the viewer is, in the camera frame [m]
        centre: what is in the middle of the picture [m]; another place
        """
        ...
    def draw(self, image: NDArray[Any], tools: _Sequence[DrawnTool], paths: _Sequence[NDArray[Any]], picture: Optional[NDArray[Any]] = ...) -> NDArray[Any]:
        """Draws the scene anew.

        image: of the camera, CV_8UC1 or CV_8UC3 of its size; empty: the frame of its field of view alone
        tools: their poses and looks; one with an opacity below 1 is seen through
        paths: N x 3 points each, floating [m], in the colours of the tools of the same index
        picture: CV_8UC3 of the view's size
        """
        ...
    def show(self, seconds: float = ...) -> None:
        """Lets the user look at the last drawing: the left button turns, the wheel comes nearer, `q` or closing the window ends it.

        seconds: ends it too; 0 = never
        Raises cv2.error if there is no window
        """
        ...

class PoseScore:
    """How good the poses of one tool are, measured against the truth."""
    def __init__(self) -> None: ...
    frames: int
    """with truth"""
    covered: int
    """of these, with a pose that claims to be one: tracking or coasting"""
    translationMean: float
    """distance of the end effector from its true place, over the covered frames [m]; 0 without any"""
    translationStd: float
    """its standard deviation [m]"""
    rotationMean: float
    """angle between estimated and true orientation, over the covered frames [rad]"""
    rotationStd: float
    """its standard deviation [rad]"""
    accuracy: float
    """share of all frames whose scored points are at most 10 pixel off, on average, in an image 720 pixel wide (paper, Sec. 3)"""
    silent: float
    """share of all frames that claim to be tracking and are more than 5 mm off"""

class PoseScorer:
    """Compares poses with the truth, as Table 1 of the paper does.

    The scored points of a tool, for PoseScore.accuracy, move with its end effector: the end effector itself, its pivot, which is the origin
    of the last link on the way to it that a joint moves, and the two points 3 mm beside the pivot on that joint's axis. Of a needle driver
    they are the tip and the axis of the jaws.
    """
    @staticmethod
    def create(camera: CameraModel, models: _Sequence[ToolModel]) -> PoseScorer:
        """A scorer without poses yet.

        camera: of the image the reprojection error is taken in; its distortion is left out
        models: of the tools, whose points are scored
        """
        ...
    def add(self, tool: int, state: int, camera_T_tool: NDArray[np.float64], true_camera_T_tool: NDArray[np.float64]) -> None:
        """Takes in one frame of one tool.

        tool: index
        state: see TrackingState
        camera_T_tool: estimate
        true_camera_T_tool: truth
        """
        ...
    def score(self, tool: int = ...) -> PoseScore:
        """The score so far.

        tool: index; -1 = all tools together
        """
        ...

def poseError(camera_T_tool: NDArray[np.float64], true_camera_T_tool: NDArray[np.float64]) -> NDArray[np.float64]:
    """What leads from an estimated pose to the true one, in the terms of ToolEstimate.covariance:
    R_true = exp(rotation) R_estimate, t_true = translation + t_estimate.

    camera_T_tool: estimate
    true_camera_T_tool: truth
    Returns: (rotation vector [rad], translation [m]), both in the camera frame
    """
    ...

def normalizedErrorSquared(error: NDArray[np.float64], covariance: NDArray[np.float64], first: int = ..., count: int = ...) -> float:
    """Normalised error squared (NEES): e^T P^-1 e of some components, as many as its mean should be if P is right.

    error: see poseError()
    covariance: see ToolEstimate.covariance
    first, count: components, by default all: 0, 3 is the rotation alone, 3, 3 the translation
    Returns: not a number if that block of the covariance is not positive definite, as without a covariance
    """
    ...

def checkSetup(sequence: Sequence, stereo: bool = ...) -> Tuple[Tuple[str, ...], Tuple[str, ...]]:
    """Looks for mistakes in the setup of a recorded sequence: units of readings and meshes, joint limits, hand-eye calibrations,
    clocks, and, with stereo, the eyes against each other. Where none of these is found, the tools are tracked in some thirty frames
    spread over the video (its first 5000 frames), to see whether arms or tool files are exchanged, clocks differ, or another instrument is
    seen. Takes seconds; where tools are not found, up to a minute.

    An instrument very much like the model's can't be told from it; nor is it looked for where a tool is never in the image.

    sequence: video and readings
    findings: what is likely to be wrong, with the probable cause and the key to change, a line each; none: nothing was found
    figures: what was seen of each tool, a line each; none if a finding came before the tracking
    stereo: the right eye is used
    Raises cv2.error if the video can't be read
    """
    ...

def checkEyes(sequence: Sequence) -> str:
    """Whether the first images of the eyes contradict `right_T_left`: corners are found where they would be with the eyes exchanged.

    sequence: with two eyes
    Returns: what is wrong, in a line; empty: nothing, or it can't be told
    """
    ...

def checkUnits(model: ToolModel, joints: NDArray[Any]) -> str:
    """Whether joint readings are in radians and metres.

    model: the tool
    joints: N x C, a reading a row
    Returns: what no instrument can have, in a line; empty: nothing
    """
    ...

def readTrackerParams(filename: str, params: ToolTracker.Params, stages: ToolTracker.Stages) -> Tuple[ToolTracker.Params, ToolTracker.Stages]:
    """Reads parameters of a tracker from a file: those it names, the others stay as they are. Keys are the names of the fields of
    ToolTracker.Params, and maps of those of ToolTracker.Stages.

    filename: YAML, XML or JSON, as writeTrackerParams() writes it
    params, stages: changed
    Raises cv2.error naming file and key: no such field, no number, or one out of its range
    """
    ...

def writeTrackerParams(filename: str, params: ToolTracker.Params, stages: ToolTracker.Stages) -> None:
    """Writes all parameters of a tracker.

    filename: YAML, XML or JSON by its ending
    params, stages: what is written
    Raises cv2.error naming the file if it can't be written
    """
    ...

def setTrackerParam(name: str, value: str, params: ToolTracker.Params, stages: ToolTracker.Stages) -> Tuple[ToolTracker.Params, ToolTracker.Stages]:
    """Sets one parameter by its name.

    name: of a field of ToolTracker.Params, as `minWindow`, or of a stage, as `matcher.minSimilarity`
    value: as text: a number; 0, 1, false or true for a flag
    params, stages: changed
    Raises cv2.error naming the parameter, and what it may be or what there is instead
    """
    ...

def readToolState(filename: str, tool: str) -> ReadingErrors:
    """What was learnt of tools, as writeToolState() wrote it.

    filename: YAML, XML or JSON
    tool: name of the tool in its sequence
    Returns: without names if the file does not name the tool
    Raises cv2.error naming file and key
    """
    ...

def writeToolState(filename: str, tools: _Sequence[str], errors: _Sequence[ReadingErrors]) -> None:
    """Writes what was learnt of tools.

    filename: YAML, XML or JSON by its ending
    tools: their names, each once
    errors: ToolTracker.readingErrors() of each
    Raises cv2.error naming the file if it can't be written; what was there before still is
    """
    ...
