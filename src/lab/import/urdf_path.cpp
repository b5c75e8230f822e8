// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "files/text_file.hpp"
#include "lab/import/urdf_path.hpp"

namespace cv { namespace surgtrack {

//! NAME/... or ... in a folder; empty if it is not there.
static String inPackage(const String& folder, const String& rest)
{
    const String whole = utils::fs::join(folder, rest);
    const size_t slash = rest.find('/');
    if (utils::fs::exists(whole) || slash == String::npos)
        return utils::fs::exists(whole) ? whole : String();
    const String inside = utils::fs::join(folder, rest.substr(slash + 1));
    return utils::fs::exists(inside) ? inside : String();
}

String urdfMeshPath(const String& filename, const String& packages, const String& name)
{
    if (name.compare(0, 7, "file://") == 0)
        return name.substr(7);
    if (name.compare(0, 10, "package://") != 0)
        return name[0] == '/' ? name : utils::fs::join(utils::fs::getParent(filename), name);
    const String rest = name.substr(10);
    if (!packages.empty())
    {
        const String found = inPackage(packages, rest);
        return found.empty() ? utils::fs::join(packages, rest) : found;
    }
    // Without it: where the URDF is, or above that, as packages have it.
    for (String folder = utils::fs::canonical(utils::fs::getParent(utils::fs::canonical(filename))), last; folder != last && !folder.empty();)
    {
        const String found = inPackage(folder, rest);
        if (!found.empty())
            return found;
        last = folder;
        folder = utils::fs::getParent(folder);
    }
    importError(filename, "mesh `" + name + "`: is neither beside the file nor above it, expected the folder of the package to be given (packages)", Error::StsObjectNotFound);
}

}} // namespace cv::surgtrack
