#pragma once

#include <fresco/dataset/manifest.h>
#include <fresco/value.h>

#include <map>
#include <string>
#include <vector>

/// The files of one view, by name relative to the folder that is being written.
struct WrittenFiles
{
    std::map<std::string, fresco::dataset::FileStamp> files;
    double sharpness = 0;  ///< fresco::sharpness at 320 x 240 of the camera picture.

    std::vector<std::string> names() const;
};

/// For the note of a view that is kept, and back.
fresco::Value to_value(const WrittenFiles& written);
WrittenFiles written_files_from(const fresco::Value& value);
