// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_IMPORT_IMPORT_JSON_HPP
#define OPENCV_SURGTRACK_SRC_LAB_IMPORT_IMPORT_JSON_HPP

#include <nlohmann/json.hpp>
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

//! A value of a JSON file that knows where it is, for errors that say so.
class JsonKey
{
public:
    JsonKey(const nlohmann::json& value, const String& filename, const String& path) : value_(&value), filename_(filename), path_(path) {}

    CV_NORETURN void fail(const String& what) const { importError(filename_, (path_.empty() ? "" : "key " + path_ + ": ") + what); }

    //! With underscores, or as old files have it, hyphens.
    bool has(const String& key) const { return find(key) != 0; }
    JsonKey operator[](const String& key) const
    {
        const nlohmann::json* value = find(key);
        const String path = path_.empty() ? key : path_ + "." + key;
        if (!value)
            importError(filename_, "key " + path + ": missing");
        return JsonKey(*value, filename_, path);
    }

    size_t size() const
    {
        if (!value_->is_array())
            fail("expected a sequence");
        return value_->size();
    }
    JsonKey operator[](size_t i) const { return JsonKey((*value_)[i], filename_, path_ + format("[%d]", (int)i)); }
    JsonKey operator[](int i) const { return (*this)[(size_t)i]; }

    String text() const
    {
        if (!value_->is_string())
            fail("expected a string");
        return value_->get<std::string>();
    }
    double number() const
    {
        const double value = value_->is_number() ? value_->get<double>() : DBL_MAX;
        if (!(std::abs(value) < DBL_MAX))
            fail("expected a finite number");
        return value;
    }
    bool boolean() const
    {
        if (!value_->is_boolean())
            fail("expected true or false");
        return value_->get<bool>();
    }

private:
    const nlohmann::json* find(String key) const
    {
        if (!value_->is_object())
            fail("expected a map");
        nlohmann::json::const_iterator at = value_->find(key);
        if (at == value_->end())
        {
            std::replace(key.begin(), key.end(), '_', '-');
            at = value_->find(key);
        }
        return at == value_->end() ? 0 : &*at;
    }

    const nlohmann::json* value_;
    String filename_, path_;
};

//! A JSON file; comments are passed over.
class JsonFile
{
public:
    explicit JsonFile(const String& filename) : filename_(filename)
    {
        try
        {
            json_ = nlohmann::json::parse(readTextFile(filename), nullptr, true, true);
        }
        catch (const nlohmann::json::exception& e)
        {
            importError(filename, String("expected JSON: ") + e.what());
        }
    }
    JsonKey root() const { return JsonKey(json_, filename_, String()); }

private:
    String filename_;
    nlohmann::json json_;
};

}} // namespace cv::surgtrack

#endif
