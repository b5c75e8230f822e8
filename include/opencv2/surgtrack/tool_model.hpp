// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_MODEL_HPP
#define OPENCV_SURGTRACK_TOOL_MODEL_HPP

#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A triangle mesh in the frame of its link [m].

Vertices on creases are stored once per side, so that a vertex has one normal. */
struct CV_EXPORTS_W_SIMPLE Mesh
{
    CV_WRAP Mesh();
    CV_WRAP Mesh(const std::vector<Point3f>& vertices, const std::vector<Point3f>& normals, const std::vector<Vec3i>& triangles);

    CV_PROP_RW std::vector<Point3f> vertices;   //!< [m]
    CV_PROP_RW std::vector<Point3f> normals;    //!< unit length, outward where the surface is closed; one per vertex
    CV_PROP_RW std::vector<Vec3i> triangles;    //!< vertex indices
};

/** @brief Reads a PLY, STL or OBJ file, by its extension.

Duplicate points are merged, polygons triangulated, normals computed (creases sharper than 35 degrees stay sharp), and
a mesh with more triangles than @p maxTriangles is decimated (quadric error).

@param filename the mesh file
@param scale metres per unit of the file
@param link_T_mesh the mesh's (scaled) frame in the frame wanted
@param maxTriangles 0 = keep all
@throws cv::Exception (StsParseError or StsObjectNotFound) naming the file: missing, truncated, of an unknown type, without
triangles, or with a vertex that is not finite */
CV_EXPORTS_W Mesh loadMesh(const String& filename, double scale, const Matx44d& link_T_mesh, int maxTriangles = 0);

/** @brief The same with all triangles, in the mesh's own frame.
@param filename the mesh file
@param scale metres per unit of the file */
CV_EXPORTS_W Mesh loadMesh(const String& filename, double scale = 1);

/** @brief An articulated tool: links and joints, meshes, and the keypoints that name its parts. Immutable.

The links form a tree. A link's pose in its parent is the modified (Craig) Denavit-Hartenberg transform
`parent_T_link = Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)`; a joint adds `scale * coordinate` to theta (revolute,
[rad]) or to d (prismatic, [m]). Several joints may share a coordinate, as the two jaws do.

The tool file (cv::FileStorage: YAML, XML or JSON) is described in doc/formats.md. */
class CV_EXPORTS_W ToolModel
{
public:
    enum JointType { JOINT_FIXED = 0, JOINT_REVOLUTE = 1, JOINT_PRISMATIC = 2 };

    struct CV_EXPORTS Link
    {
        String name;
        int parent;               //!< index of the parent link, always smaller than the link's own; -1: the base
        JointType jointType;
        int coordinate;           //!< index into coordinateNames(); -1 for a fixed joint
        double scale;             //!< joint value = scale * coordinate
        double alpha, a, theta, d;
        int mesh;                 //!< index into meshes(); -1: nothing to draw
        double offsetDeviation;   //!< for offsetDeviations(), the same in all links of a coordinate [rad or m]; negative: the default, as of the next three
        double gainDeviation;     //!< of a joint that turns: see ArticulatedPoseEKF::Params::gain,
        double playDeviation;     //!< play [rad],
        double couplingDeviation; //!< and coupling
        Link();
    };

    struct CV_EXPORTS Keypoint
    {
        String name;
        int link;
        Point3d linkPoint;        //!< in the link's frame [m]
        double score;             //!< see chooseKeypoints(), 0..1; negative: not known
        Keypoint();
    };

    /** @brief Everything a tool consists of, to build one in code. */
    struct CV_EXPORTS Description
    {
        String name;
        std::vector<String> coordinates;
        std::vector<Link> links;
        std::vector<Mesh> meshes;
        std::vector<Keypoint> keypoints;
        std::vector<Vec2d> limits;   //!< least and greatest value of each coordinate [rad or m], -DBL_MAX and DBL_MAX: none; empty: not known
        int endEffectorLink;
        Matx44d link_T_endEffector;
        Description();
    };

    /** @brief Reads a tool file and its meshes (paths relative to the tool file).
    @param filename YAML, XML or JSON
    @param maxTriangles a tool with more triangles than this is decimated, all meshes to the same closeness; 0 = never
    @throws cv::Exception naming the file, the key and what was expected */
    CV_WRAP static Ptr<ToolModel> load(const String& filename, int maxTriangles = 20000);

    /** @brief The built-in tool: an 8 mm wristed needle driver drawn from its dimensions (shaft radius 4.2 mm, pitch to yaw
    axis 9.1 mm, yaw axis to tip 9.65 mm) on the kinematics of a patient side manipulator, with 14 keypoints. */
    CV_WRAP static Ptr<ToolModel> needleDriver();

    /** @brief Another built-in tool: curved scissors of 8 mm on the same kinematics. Both blades are bent to the same side, so that no half is the
    other's mirror image. Its keypoints are those that chooseKeypoints() takes. */
    CV_WRAP static Ptr<ToolModel> curvedScissors();

    /** @brief A tool from its description. @throws cv::Exception if an index, a matrix or a number is not valid */
    static Ptr<ToolModel> create(const Description& description);

    /** @brief Writes the tool file, and its meshes as PLY into the folder `meshes` beside it. */
    CV_WRAP void save(const String& filename) const;

    /** @brief The tool's name. */
    CV_WRAP String name() const { return description_.name; }
    /** @brief Names of the coordinates, in the order of all `joints` arguments. */
    CV_WRAP std::vector<String> coordinateNames() const { return description_.coordinates; }
    /** @brief Names of the links, parents before their children. */
    CV_WRAP std::vector<String> linkNames() const;
    /** @brief Names of the keypoints, in the order of keypointPositions(). */
    CV_WRAP std::vector<String> keypointNames() const;
    const std::vector<Link>& links() const { return description_.links; }
    /** @brief The meshes that links refer to. */
    CV_WRAP const std::vector<Mesh>& meshes() const { return description_.meshes; }
    const std::vector<Keypoint>& keypoints() const { return description_.keypoints; }
    const Description& description() const { return description_; }
    /** @brief How far the joints go: C x 2 CV_64F, least and greatest value of each coordinate [rad or m]; -DBL_MAX and DBL_MAX where that is not known. */
    CV_WRAP Mat jointLimits() const;
    /** @brief How well keypoints are found, see chooseKeypoints(): 0..1, negative where that is not known. */
    CV_WRAP std::vector<double> keypointScores() const;
    /** @brief Index of the coordinate, or -1. */
    CV_WRAP int coordinateIndex(const String& name) const;

    /** @brief Index of the link that carries the end effector. */
    CV_WRAP int endEffectorLink() const { return description_.endEffectorLink; }

    /** @brief How wrong joint readings may be: prior standard deviation of a constant offset, one per coordinate [rad or m]; 0 = exact,
    or not to be told from an error of the hand-eye calibration. What the links of a coordinate state (Link::offsetDeviation);
    by default 0.03 rad for revolute joints beyond one that slides, and 0 for all others. */
    CV_WRAP std::vector<double> offsetDeviations() const;

    /** @brief A mesh.
    @param index mesh index, see linkMesh()
    @param vertices V x 3 CV_32F [m], in the frame of its link
    @param triangles T x 3 CV_32S */
    CV_WRAP void getMesh(int index, OutputArray vertices, OutputArray triangles) const;

    /** @brief The mesh that a link carries: an index for getMesh(), or -1. @param link index */
    CV_WRAP int linkMesh(int link) const;

    /** @brief Poses of all links.
    @param joints one value per coordinate [rad or m], finite
    @param base_T_link one per link */
    void forwardKinematics(InputArray joints, std::vector<Matx44d>& base_T_link) const;

    /** @brief Poses of all links, as an array.
    @param joints one value per coordinate [rad or m], finite
    @return base_T_link, L x 4 x 4 CV_64F, in the order of linkNames() */
    CV_WRAP Mat linkPoses(InputArray joints) const;

    /** @brief The end effector's pose.
    @param joints one value per coordinate [rad or m]
    @return base_T_tool, the end effector's pose in the base frame */
    CV_WRAP Matx44d endEffectorPose(InputArray joints) const;

    /** @brief The end effector's pose, from those of the links.
    @param base_T_link as forwardKinematics() or linkPoses() give them
    @return base_T_tool */
    CV_WRAP Matx44d endEffectorFromLinks(const std::vector<Matx44d>& base_T_link) const;

    /** @brief Keypoints in the base frame.
    @param joints one value per coordinate [rad or m]
    @param basePoints K x 3 CV_64F [m]
    @param jacobian if wanted, 3K x C CV_64F: d(basePoints) / d(coordinates), rows x, y, z of keypoint 0, then of keypoint 1, ... */
    CV_WRAP void keypointPositions(InputArray joints, OutputArray basePoints, OutputArray jacobian = noArray()) const;

    /** @brief The joint Jacobian of any point fixed to a link.
    @param base_T_link as forwardKinematics() gives them
    @param link the link that carries the point
    @param basePoint the point in the base frame [m]
    @param jacobian 3 x C, row-major, is overwritten */
    void pointJacobian(const std::vector<Matx44d>& base_T_link, int link, const Point3d& basePoint, double* jacobian) const;

    /** @brief The joint Jacobian of any point fixed to a link, as a matrix.
    @param base_T_link as forwardKinematics() or linkPoses() give them
    @param link the link that carries the point
    @param basePoint the point in the base frame [m]
    @param jacobian 3 x C CV_64F */
    CV_WRAP void pointJacobian(const std::vector<Matx44d>& base_T_link, int link, const Point3d& basePoint, OutputArray jacobian) const;

private:
    explicit ToolModel(const Description& description);
    Description description_;
};

//! @}

}} // namespace cv::surgtrack

#endif
