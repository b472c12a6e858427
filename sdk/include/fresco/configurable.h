#pragma once

#include <fresco/option_declaration.h>
#include <fresco/value.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

class Configurable;
class Component;
class InputPort;
class OutputPort;

/// Argument of an input that a pipeline may leave unwired, and of a slot that it may leave empty.
struct Optional
{
};
inline constexpr Optional optional{};

/// Makes the components that a configuration names. The host implements it; tests use fresco::testing.
class ComponentFactory
{
  public:
    virtual ~ComponentFactory();
    /// A configured component for `{type: …, options…}`. Equal configurations give one shared object, so that two losses on one
    /// feature network encode once. Throws Error if the type is unknown or not of `kind`.
    virtual std::shared_ptr<Component> create(std::string_view kind, const Value& config) = 0;
};

/// One declared setting of a stage or component: an Option, a Slot or a SlotMap. Registers itself with its owner.
class Parameter
{
  public:
    Parameter(Configurable* owner, OptionDeclaration declaration);
    virtual ~Parameter();
    Parameter(const Parameter&) = delete;
    Parameter& operator=(const Parameter&) = delete;

    /// Everything a user or an editor must know.
    const OptionDeclaration& declaration() const { return declaration_; }
    const std::string& name() const { return declaration_.name; }
    /// Sets it to a value that check_value accepts; throws Error naming the option, the value and what is accepted.
    void assign(const Value& value, ComponentFactory& factory);

  protected:
    /// `value` is as check_value gave it.
    virtual void set(const Value& value, ComponentFactory& factory) = 0;
    OptionDeclaration declaration_;
};

/// Base of stages and components: owns nothing but a list of the parameters and ports declared as its members. Constructors do
/// no work. Used by one thread at a time unless a contract says otherwise.
class Configurable
{
  public:
    Configurable();
    virtual ~Configurable();
    Configurable(const Configurable&) = delete;
    Configurable& operator=(const Configurable&) = delete;

    const std::vector<Parameter*>& parameters() const { return parameters_; }
    const std::vector<InputPort*>& inputs() const { return inputs_; }
    const std::vector<OutputPort*>& outputs() const { return outputs_; }

    /// Assigns every entry of the map `options`; what is not named keeps its default. Throws Error on an unknown name.
    void configure(const Value& options, ComponentFactory& factory);
    /// The declaration as a map with the keys options, inputs, outputs.
    Value describe() const;

  private:
    friend class Parameter;
    friend class InputPort;
    friend class OutputPort;
    std::vector<Parameter*> parameters_;
    std::vector<InputPort*> inputs_;
    std::vector<OutputPort*> outputs_;
};

}  // namespace fresco
