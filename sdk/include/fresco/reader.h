#pragma once

#include <fresco/artifact.h>
#include <fresco/component.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace fresco
{

/// Reads an artifact from a user's file, for `{file: PATH}` on a port. The host picks the reader by artifact and extension; the
/// file's contents and the reader's library enter the consumer's cache key.
class FileReader : public Component
{
  public:
    static constexpr std::string_view component_kind = "reader";
    ~FileReader() override;
    /// The artifact_name of what it makes.
    virtual std::string artifact() const = 0;
    /// Lower case, with the dot: ".png". A file of another is not read by it; fresco check looks at the file as for Extensions.
    virtual std::vector<std::string> extensions() const = 0;
    virtual std::shared_ptr<const Artifact> read(const std::filesystem::path& file) = 0;
};

}  // namespace fresco
