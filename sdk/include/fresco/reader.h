#pragma once

#include <fresco/artifact.h>
#include <fresco/component.h>
#include <fresco/option_declaration.h>

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
    /// Extensions of the files that it reads, lower case, with the dot: ".png". Default: those of formats().
    virtual std::vector<std::string> extensions() const;
    /// First bytes of such files, which fresco check compares; empty if unknown.
    virtual std::vector<FileFormat> formats() const { return {}; }
    virtual std::shared_ptr<const Artifact> read(const std::filesystem::path& file) = 0;
};

/// Reads from a file that a stage wrote how it was made, for `fresco describe FILE`. The host picks it by extension.
class FileOrigin : public Component
{
  public:
    static constexpr std::string_view component_kind = "origin";
    ~FileOrigin() override;
    /// Lower case, with the dot.
    virtual std::vector<std::string> extensions() const = 0;
    /// RunContext::origin of the stage. Throws Error naming the file, MissingInput where there is none.
    virtual Value origin(const std::filesystem::path& file) const = 0;
};

}  // namespace fresco
