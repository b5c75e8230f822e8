// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/joint_names.hpp"
#include "files/mesh_check.hpp"
#include "files/mesh_reader.hpp"
#include "files/ply_reader.hpp"
#include "files/text_file.hpp"

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace cv { namespace surgtrack {

namespace {

std::string contentOf(const String& filename)
{
    const std::string data = readContent(filename, "a mesh file");
    if (data.compare(0, 42, "version https://git-lfs.github.com/spec/v1") == 0)
        CV_Error(Error::StsParseError, filename + ": is the pointer git-LFS leaves in the place of a file, expected the mesh itself: run `git lfs pull` "
                                                  "where it comes from");
    return data;
}

void append(const aiMesh& part, Mesh& mesh)
{
    const int first = (int)mesh.vertices.size();
    for (unsigned i = 0; i < part.mNumVertices; ++i)
        mesh.vertices.push_back(Point3f(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z));
    for (unsigned i = 0; i < part.mNumFaces; ++i)
    {
        const aiFace& face = part.mFaces[i];
        if (face.mNumIndices == 3)
            mesh.triangles.push_back(Vec3i(first + (int)face.mIndices[0], first + (int)face.mIndices[1], first + (int)face.mIndices[2]));
    }
}

} // namespace

Mesh readMeshFile(const String& filename)
{
    std::string data = contentOf(filename);
    const size_t dot = filename.rfind('.');
    const String extension = dot == String::npos ? String() : lowerCase(filename.substr(dot + 1));
    if (data.compare(0, 10, "ISO-10303-") == 0 || extension == "step" || extension == "stp" || extension == "iges" || extension == "igs")
        CV_Error(Error::StsParseError, filename + ": is of surfaces (STEP, IGES), expected triangles: CAD programs export these as STL");
    if (extension == "ply" || extension == "stl")
    {
        const Mesh mesh = extension == "ply" ? PlyReader(filename, data).read() : MeshCheck(filename, data).readSTL();
        if (mesh.triangles.empty())
            CV_Error(Error::StsParseError, filename + ": expected at least one triangle");
        return mesh;
    }
    const bool obj = extension == "obj";
    if (obj)
        data = MeshCheck(filename, data).checkedOBJ();

    Assimp::Importer importer;
    if (extension.empty() || !importer.IsExtensionSupported("." + extension))
        CV_Error(Error::StsParseError, filename + ": expected a mesh file, its name ending in .ply, .stl, .obj, .dae or another that Assimp reads");
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_LINE | aiPrimitiveType_POINT);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);   // as ROS has it: axes are those of the file
    const unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices | aiProcess_ValidateDataStructure;
    const aiScene* const scene = obj ? importer.ReadFileFromMemory(data.data(), data.size(), steps, extension.c_str()) : importer.ReadFile(filename, steps);
    Mesh mesh;
    for (unsigned i = 0; scene && i < scene->mNumMeshes; ++i)
        append(*scene->mMeshes[i], mesh);
    if (mesh.triangles.empty())
        importError(filename, "expected at least one triangle" + (*importer.GetErrorString() ? String(" (") + importer.GetErrorString() + ")" : String()));
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!checkRange(Vec3f(mesh.vertices[i])))
            CV_Error(Error::StsParseError, filename + format(": expected finite numbers, vertex %d is not", (int)i));
    return mesh;
}

}} // namespace cv::surgtrack
