// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Which sequences evaluate is given, and where the result of each is kept.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_FILES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_FILES_HPP

#ifndef _WIN32
#include <dlfcn.h>
#else
#include <process.h>
#endif
#include "data.hpp"
#include "../support/sequences.hpp"

namespace evaluation {

using common::absolutePath;
using common::baseName;
using common::findSequences;

//! A number for the contents of files and texts (FNV-1a, 64 bit): another one as soon as a byte is another.
class Fingerprint
{
public:
    Fingerprint() : hash_(14695981039346656037ULL) {}

    void add(const char* bytes, size_t count)
    {
        for (size_t i = 0; i < count; i++)
            hash_ = (hash_ ^ (uchar)bytes[i]) * 1099511628211ULL;
    }
    void add(const String& text) { add(text.c_str(), text.size() + 1); }
    void addFile(const String& filename)
    {
        std::ifstream file(filename.c_str(), std::ios::binary);
        std::vector<char> block(1 << 16);
        add(String(file ? "file" : "none"));
        for (std::streamsize count = (std::streamsize)block.size(); file && count > 0; add(block.data(), (size_t)count))
        {
            file.read(block.data(), count);
            count = file.gcount();
        }
    }
    String text() const { return format("%08x%08x", (unsigned)(hash_ >> 32), (unsigned)hash_); }

private:
    uint64 hash_;
};

//! The file that holds the tracker; empty where the system does not tell.
inline String trackerFile()
{
#ifdef _WIN32
    return String();
#else
    // An object of the module points to the table of its virtual functions; the address of a function may be a stub of this program.
    const Ptr<GeometricContextVerifier> object = GeometricContextVerifier::create();
    Dl_info info;
    return dladdr(*reinterpret_cast<void* const*>(object.get()), &info) && info.dli_fname ? String(info.dli_fname) : String();
#endif
}

inline void addSequence(Fingerprint& print, const String& folder)
{
    print.add(absolutePath(folder));
    print.addFile(utils::fs::isDirectory(folder) ? utils::fs::join(folder, "sequence.yaml") : folder);
    try
    {
        const Ptr<Sequence> sequence = Sequence::load(folder);
        print.addFile(sequence->kinematicsFile());
        print.addFile(sequence->groundTruthFile());
        print.addFile(sequence->keypointsFile());
        print.addFile(sequence->leftVideo());
        print.addFile(sequence->rightVideo());
        for (int i = 0; i < sequence->toolCount(); i++)
        {
            const String model = sequence->tool(i).model, parent = utils::fs::getParent(model);
            print.addFile(model);
            if (!utils::fs::exists(model))
                continue;
            const FileStorage file(model, FileStorage::READ);
            const FileNode links = file["links"];
            for (int j = 0; j < (int)links.size(); j++)
                if (links[j]["mesh"].isString())
                    print.addFile(utils::fs::join(parent.empty() ? String(".") : parent, links[j]["mesh"].string()));
        }
    }
    catch (const Exception&)
    {
        // Evaluating it will tell.
    }
}

/** The result of a sequence, without the ending of the name: another one for another sequence, contents of its files, tracker or settings.
@param folder where results are */
inline String resultName(const String& folder, const String& sequence, const String& settings)
{
    static const String tracker = trackerFile();
    Fingerprint print;
    print.add("2 " + settings);   // the number changes with the format
    print.addFile(tracker);
    addSequence(print, sequence);
    return utils::fs::join(folder, plainName(baseName(absolutePath(sequence))) + "-" + print.text());
}

//! A name beside a file, for what is being written: no other process has it.
inline String partOf(const String& filename)
{
#ifdef _WIN32
    const int process = _getpid();
    const char* const host = "";
#else
    const int process = (int)getpid();
    char host[256] = "";
    gethostname(host, sizeof(host) - 1);
#endif
    return utils::fs::join(utils::fs::getParent(filename), format("part-%s-%d-", host, process) + baseName(filename));
}

} // namespace evaluation

#endif
