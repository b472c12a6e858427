#pragma once

#include <fresco/option_declaration.h>
#include <fresco/port.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// \file For a stage that runs a program of the user's, and for the host that checks it before: the words of a CommandLine
/// option, and ports that a pipeline declares ({port: artifact} or {port: {artifact: …, as: …}}), of any artifact.

namespace fresco
{

/// The names in braces of a word: "--out={result}" has "result". "{{" and "}}" stand for braces. Throws Error for a brace without
/// its other.
std::vector<std::string> names_in(std::string_view word);

/// The word with each {name} replaced. Throws as names_in, and for a name that is not among `values`.
std::string filled_in(std::string_view word, const std::map<std::string, std::string>& values);

/// One thing that keeps a program from being run as it is declared.
struct CommandLineProblem
{
    std::string option;  ///< Option that holds it,
    int word = -1;       ///< and at which word of it; -1: the option as a whole.
    std::string text;
    bool is_missing = false;  ///< A program that is not there; otherwise the pipeline is wrong.
};

/// Checks the command lines of a stage against its files and ports: unknown {names}, outputs that no word passes to the program,
/// files that are used but not declared, programs that there are not. `values` are the checked values of `options`; `folder_of`
/// gives the folder that a relative path in an option's word starts from.
std::vector<CommandLineProblem>
check_command_line(const std::vector<OptionDeclaration>& options, const Value& values,
                   const std::function<std::filesystem::path(const std::string& option, std::size_t word)>& folder_of);

class DeclaredInput final : public InputPort
{
  public:
    DeclaredInput(Configurable* owner, const std::string& name, const ArtifactType& type, const ExchangeForm& form);
    void load(const ArtifactFolder& folder) override { stored_ = folder; }
    void set(std::shared_ptr<const Artifact> value) override { value_ = std::move(value); }

    /// The path that a program gets: in `folder`, which is empty, or where the artifact lies. Throws Error.
    std::filesystem::path hand_over(const std::filesystem::path& folder, const ImageIo* images, RunContext& run) const;

  private:
    const ExchangeForm& form_;
    ArtifactFolder stored_;
    std::shared_ptr<const Artifact> value_;
};

class DeclaredOutput final : public OutputPort
{
  public:
    DeclaredOutput(Configurable* owner, const std::string& name, const ArtifactType& type, const ExchangeForm& form);
    // It is in its folder once it was taken back.
    void save() const override {}
    std::shared_ptr<const Artifact> value() const override { return nullptr; }

    /// The path that a program gets for what it makes: in `scratch`, which is empty, or the artifact's own folder.
    std::filesystem::path place(const std::filesystem::path& scratch) const;
    /// Reads what a program made of the same `scratch`, with all checks, and writes it to its final form. Throws Error naming
    /// what is missing or wrong.
    void take_back(const std::filesystem::path& scratch, const ImageIo* images, RunContext& run) const;

  private:
    const ExchangeForm& form_;
};

/// Option of the kind input_ports or output_ports: makes the ports when it is configured.
template <class Port>
class DeclaredPorts final : public Parameter
{
  public:
    /// Outputs are required: a result without any could not be kept.
    DeclaredPorts(Configurable* owner, std::string name, std::string help);
    const std::vector<std::unique_ptr<Port>>& operator*() const { return ports_; }

  private:
    void set(const Value& value, ComponentFactory& factory) override;

    Configurable* owner_;
    std::vector<std::unique_ptr<Port>> ports_;
};
extern template class DeclaredPorts<DeclaredInput>;
extern template class DeclaredPorts<DeclaredOutput>;
using InputPorts = DeclaredPorts<DeclaredInput>;
using OutputPorts = DeclaredPorts<DeclaredOutput>;

}  // namespace fresco
