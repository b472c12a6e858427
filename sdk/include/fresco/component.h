#pragma once

#include <fresco/error.h>
#include <fresco/option_declaration.h>
#include <fresco/value.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file What stages and components have in common, and how a stage holds the components that a pipeline chooses for it. Plugins
/// derive from Stage (stage.h) or from a component's contract, and declare options, slots and ports as members.

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
    /// The declaration as a map with the keys options, components (the slots that the pipeline fills), inputs, outputs, and of a
    /// component that has any, marks.
    Value describe() const;

  private:
    friend class Parameter;
    friend class InputPort;
    friend class OutputPort;
    std::vector<Parameter*> parameters_;
    std::vector<InputPort*> inputs_;
    std::vector<OutputPort*> outputs_;
};

/// A part chosen inside a stage by the same `type:` key. A contract (a loss, a feature network, an image codec) derives from
/// Component and has `static constexpr std::string_view component_kind`; its destructor is out of line in one shared library.
class Component : public Configurable
{
  public:
    ~Component() override;
    /// By what a slot that is ByMarks chooses this component. The default: by nothing; a pipeline names it.
    virtual Marks marks() const { return {}; }
};

/// Argument of a slot that stays empty unless a port that the pipeline declares (DeclaredPorts) has this exchange form.
struct ForForm
{
    std::string name;
};

/// Argument of a slot whose default, the word `auto`, is the component whose Marks fit the folder or file that the owner's option
/// `option` names. The host puts its type in place of the word when the pipeline is checked.
struct ByMarks
{
    std::string option;
};

namespace detail
{
/// Untyped half of Slot and SlotMap.
class SlotBase : public Parameter
{
  public:
    ~SlotBase() override;

  protected:
    /// `default_config` as Slot and SlotMap say.
    SlotBase(Configurable* owner, std::string name, OptionKind kind, std::string_view component_kind,
             const std::string& default_config, std::string help, std::string chosen_by = "");
    /// The component that the pipeline has chosen for the kind.
    SlotBase(Configurable* owner, std::string_view component_kind, std::string_view default_type, bool is_optional,
             std::string for_form, std::string help);
    std::shared_ptr<Component> make(const Value& config, ComponentFactory& factory) const;
    [[noreturn]] void wrong_contract(const Value& config) const;
    [[noreturn]] void not_assigned() const;
};
}  // namespace detail

/// One component. `default_config` is a type ("loss.gram") or a JSON map; the host fills it in before the key is made, so
/// another default is another key. A slot with an empty default, or declared optional, may hold nothing (the word `none` in the
/// pipeline): test it with has_value().
///
/// A slot without a name holds the component that the pipeline has chosen for all its stages: `components: {KIND: …}` at the top
/// of the file, by default the contract's `default_type`. Such a slot is called as its kind.
template <class T>
class Slot final : public detail::SlotBase
{
  public:
    Slot(Configurable* owner, std::string name, const std::string& default_config, std::string help)
        : SlotBase(owner, std::move(name), OptionKind::component, T::component_kind, default_config, std::move(help))
    {
    }
    Slot(Configurable* owner, std::string help) : SlotBase(owner, T::component_kind, T::default_type, false, "", std::move(help))
    {
    }
    Slot(Configurable* owner, Optional, std::string help)
        : SlotBase(owner, T::component_kind, T::default_type, true, "", std::move(help))
    {
    }
    Slot(Configurable* owner, ForForm form, std::string help)
        : SlotBase(owner, T::component_kind, T::default_type, true, std::move(form.name), std::move(help))
    {
    }

    Slot(Configurable* owner, std::string name, ByMarks by, std::string help)
        : SlotBase(owner, std::move(name), OptionKind::component, T::component_kind, "auto", std::move(help),
                   std::move(by.option))
    {
    }

    bool has_value() const { return component_ != nullptr; }
    T& operator*() const { return *get(); }
    T* operator->() const { return get().get(); }
    /// Throws Error naming the slot if it holds nothing.
    const std::shared_ptr<T>& get() const
    {
        if (!component_)
            not_assigned();
        return component_;
    }

  private:
    void set(const Value& value, ComponentFactory& factory) override
    {
        component_ = std::dynamic_pointer_cast<T>(make(value, factory));
        if (!component_)
            wrong_contract(value);
    }

    std::shared_ptr<T> component_;
};

/// Named components, in the order of the names. The default is a JSON map {name: {type: …}, …}; without one the pipeline must
/// name them.
template <class T>
class SlotMap final : public detail::SlotBase
{
  public:
    SlotMap(Configurable* owner, std::string name, const std::string& default_config, std::string help)
        : SlotBase(owner, std::move(name), OptionKind::components, T::component_kind, default_config, std::move(help))
    {
    }

    const std::map<std::string, std::shared_ptr<T>>& operator*() const { return components_; }
    const std::map<std::string, std::shared_ptr<T>>* operator->() const { return &components_; }

  private:
    void set(const Value& value, ComponentFactory& factory) override
    {
        components_.clear();
        for (const auto& [key, config] : value.as_map())
        {
            auto made = std::dynamic_pointer_cast<T>(make(config, factory));
            if (!made)
                wrong_contract(config);
            components_.emplace(key, std::move(made));
        }
    }

    std::map<std::string, std::shared_ptr<T>> components_;
};

}  // namespace fresco
