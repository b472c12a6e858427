#pragma once

#include <fresco/artifact.h>
#include <fresco/component.h>

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// \file What a stage reads and makes, declared as members: Input<Mesh>, Output<Frames>. The host wires them by these
/// declarations, loads inputs before `run` and saves outputs after it.

namespace fresco
{

/// Common base of inputs and outputs.
class Port
{
  public:
    virtual ~Port();
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;
    const std::string& name() const { return name_; }
    const ArtifactType& type() const { return type_; }
    bool is_optional() const { return optional_; }
    Value describe() const;

  protected:
    Port(std::string name, const ArtifactType& type, bool is_optional, std::string help);

  private:
    std::string name_;
    const ArtifactType& type_;
    bool optional_;
    std::string help_;
};

/// Untyped half of Input: what the host sees.
class InputPort : public Port
{
  public:
    ~InputPort() override;
    /// Loads the value from a stored artifact's folder.
    virtual void load(const ArtifactFolder& folder) = 0;
    /// Takes a value made elsewhere (a reader, a test). Throws Error if it is of another type.
    virtual void set(std::shared_ptr<const Artifact> value) = 0;

  protected:
    InputPort(Configurable* owner, std::string name, const ArtifactType& type, bool is_optional, std::string help);
    [[noreturn]] void not_wired() const;
    [[noreturn]] void wrong_type() const;
};

/// An input: `*port` and `port->` give the value during `run`. Shared with other consumers, read-only.
template <class T>
class Input final : public InputPort
{
  public:
    Input(Configurable* owner, std::string name, std::string help)
        : InputPort(owner, std::move(name), RegisteredArtifact<T>::type, false, std::move(help))
    {
    }
    Input(Configurable* owner, std::string name, Optional, std::string help)
        : InputPort(owner, std::move(name), RegisteredArtifact<T>::type, true, std::move(help))
    {
    }

    bool has_value() const { return value_ != nullptr; }
    const T& operator*() const { return get(); }
    const T* operator->() const { return &get(); }
    /// Folder of the value in the store; empty for one that was made elsewhere, as by a reader.
    const std::filesystem::path& folder() const { return folder_; }

    void load(const ArtifactFolder& folder) override
    {
        value_ = T::load(folder);
        folder_ = folder.path;
    }
    void set(std::shared_ptr<const Artifact> value) override
    {
        folder_.clear();
        value_ = std::dynamic_pointer_cast<const T>(std::move(value));
        if (!value_)
            wrong_type();
    }

  private:
    const T& get() const
    {
        if (!value_)
            not_wired();
        return *value_;
    }
    std::shared_ptr<const T> value_;
    std::filesystem::path folder_;
};

/// Untyped half of Output.
class OutputPort : public Port
{
  public:
    ~OutputPort() override;
    /// Optional, and the stage gave no value: there is nothing to save.
    bool is_left_out() const { return is_optional() && value() == nullptr; }
    /// The names of the parts that the artifact always has; empty where they depend on what is read.
    const std::vector<std::string>& parts() const { return parts_; }
    Value describe() const;
    /// Before `run`: where the artifact goes.
    void set_folder(ArtifactFolder folder);
    /// After save(): the ids of the results in the store that the artifact refers to.
    const std::set<std::string>& references() const { return references_; }
    /// After `run`: writes the value; throws Error if the stage gave none.
    virtual void save() const = 0;
    virtual std::shared_ptr<const Artifact> value() const = 0;

  protected:
    OutputPort(Configurable* owner, std::string name, const ArtifactType& type, bool is_optional, std::string help,
               std::vector<std::string> parts = {});
    [[noreturn]] void no_value() const;
    ArtifactFolder folder_;

  private:
    std::vector<std::string> parts_;
    std::set<std::string> references_;
};

/// Argument of an output whose artifact always has the same named parts: rules for others are refused before a run.
struct Parts
{
    std::vector<std::string> names;
};

/// An output: assign it once in `run`. An artifact that streams writes into folder() while the stage runs. An optional one may be
/// left without a value, where what the stage reads has none: an optional input wired to it is then empty, any other is an error
/// of the run.
template <class T>
class Output final : public OutputPort
{
  public:
    Output(Configurable* owner, std::string name, std::string help)
        : OutputPort(owner, std::move(name), RegisteredArtifact<T>::type, false, std::move(help))
    {
    }
    Output(Configurable* owner, std::string name, Parts parts, std::string help)
        : OutputPort(owner, std::move(name), RegisteredArtifact<T>::type, false, std::move(help), std::move(parts.names))
    {
    }
    Output(Configurable* owner, std::string name, Optional, std::string help)
        : OutputPort(owner, std::move(name), RegisteredArtifact<T>::type, true, std::move(help))
    {
    }

    Output& operator=(T value)
    {
        value_ = std::make_shared<const T>(std::move(value));
        return *this;
    }
    const ArtifactFolder& folder() const { return folder_; }

    void save() const override
    {
        if (!value_)
            no_value();
        value_->save(folder_);
    }
    std::shared_ptr<const Artifact> value() const override { return value_; }

  private:
    std::shared_ptr<const T> value_;
};

}  // namespace fresco
