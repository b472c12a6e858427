#pragma once

#include <fresco/port.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/// \file Ports that a pipeline declares: {port: artifact} or {port: {artifact: …, as: …}}, for stages of any artifact.

namespace fresco
{

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
    std::shared_ptr<const Artifact> load(const ArtifactFolder& folder) const override { return type().load(folder); }

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
