#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace fresco::host
{

/// Which stage writes which file below `--out`: no two may write the same.
class OutputOwners
{
  public:
    /// Notes that the stage writes `path`, relative to `--out`. Where another stage does so already: what is wrong, and that
    /// another value of `option` helps.
    std::optional<std::string> claim(const std::filesystem::path& path, const std::string& stage,
                                     const std::string& option = "path");

  private:
    std::map<std::filesystem::path, std::string> owners_;
};

}  // namespace fresco::host
