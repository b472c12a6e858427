#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace fresco::host
{

/// Which stage writes what below `--out`: no two may write the same, nor one into a folder that another writes as a file.
class OutputOwners
{
  public:
    /// Notes that the stage writes `path`, relative to `--out`: a file, or a folder of files. If another stage is in the way,
    /// says so, and that another value of `option` helps.
    std::optional<std::string> claim(const std::filesystem::path& path, const std::string& stage, bool is_file,
                                     const std::string& option = "path");

  private:
    struct Owner
    {
        std::string stage;
        bool is_file;
    };
    using Owners = std::map<std::filesystem::path, Owner>;
    static std::string blocked(const Owners::value_type& file, const Owners::value_type& below, const std::string& option);

    Owners owners_;
};

}  // namespace fresco::host
