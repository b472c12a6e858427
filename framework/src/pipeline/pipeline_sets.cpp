#include "pipeline/pipeline_sets.h"
#include "base/text.h"
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/ranges.h>
#include <span>

namespace fresco::host
{
namespace
{
using Path = std::vector<std::string>;

YamlNode parse_value(const std::string& text, const std::shared_ptr<const YamlSource>& source, ProblemList& problems)
{
    if (!text.empty() && std::string_view("[{\"'").find(text.front()) != std::string_view::npos)
    {
        bool complete = false;
        const std::size_t before = problems.size();
        YamlNode node = parse_yaml(text, source, problems, complete);
        if (!complete || problems.size() > before)
            node.kind = YamlNode::Kind::invalid;
        return node;
    }
    YamlNode node(YamlNode::Kind::scalar, {0, 0, source});
    node.text = text;
    // An empty value is an empty text, not a missing one.
    node.plain = !text.empty();
    return node;
}

/// Puts one value at a path inside the configuration of a stage or component. Makes what is not there: the check of the stage
/// reports what should not be.
class Setter
{
  public:
    Setter(const Path& path, const YamlNode& value, TypeTable& types, ProblemList& problems)
        : path_(path), value_(value), types_(types), problems_(problems)
    {
    }

    /// `node` holds the options (and `type`) of a component of `kind`, or, if `named`, such components by name; of an empty kind,
    /// anything. path_[at] names one of them.
    void set(YamlNode& node, std::string_view kind, bool named, std::size_t at)
    {
        const std::string& key = path_[at];
        const bool has_options = !kind.empty() && !named;
        if (at + 1 == path_.size())
        {
            if (has_options && key == "type")
                drop_options(node, kind);
            node.set(key, value_);
            return;
        }
        // A type that is not known is reported elsewhere.
        if (has_options && key != "input" && !type_of(node, kind))
            return;
        const OptionDeclaration* slot = has_options ? slot_of(node, kind, key) : nullptr;
        YamlNode::Entry* entry = node.find(key);
        YamlNode& inner = entry ? entry->value : node.set(key, YamlNode(YamlNode::Kind::map, {0, 0, value_.source}));
        const bool many = slot && slot->kind == OptionKind::components;
        if (inner.is_scalar() && (named || (slot && !many)))
        {
            YamlNode map(YamlNode::Kind::map, inner);
            map.set("type", inner);
            inner = std::move(map);
        }
        if (inner.is_map())
            set(inner, slot ? slot->component_kind : named ? kind : "", many, at + 1);
        else if (inner.is_valid())
            problems_.add(value_, "'" + fmt::format("{}", fmt::join(std::span(path_).first(at + 1), ".")) + "' is " +
                                      inner.summary() + " in the file, not a map with '" + path_[at + 1] +
                                      "': set it as a whole");
    }

  private:
    KnownType type_of(const YamlNode& config, std::string_view kind)
    {
        const std::optional<std::string> name = type_named_by(config, "", nullptr);
        return name ? types_.find(*name, kind) : KnownType{};
    }

    /// The slot `key` of the type that `config` names, with its default written out.
    const OptionDeclaration* slot_of(YamlNode& config, std::string_view kind, const std::string& key)
    {
        const KnownType type = type_of(config, kind);
        const OptionDeclaration* option = type ? type.declaration->option(key) : nullptr;
        if (!option || !option->is_slot())
            return nullptr;
        if (!config.find(key) && !option->default_value.is_null())
            config.set(key, yaml_from_value(option->default_value, config));
        return option;
    }

    /// An option of the old type means nothing to the new one; where a stage's inputs come from still does.
    void drop_options(YamlNode& config, std::string_view kind)
    {
        const YamlNode::Entry* old = config.find("type");
        if (old && old->value.is_scalar() && old->value.text != value_.text)
            std::erase_if(config.entries,
                          [&](const YamlNode::Entry& entry) { return !(kind == "stage" && entry.key == "input"); });
    }

    const Path& path_;
    const YamlNode& value_;
    TypeTable& types_;
    ProblemList& problems_;
};

std::string shown_value(const std::string& value)
{
    constexpr std::size_t longest = 40;
    return value.size() <= longest && value.find('\n') == std::string::npos ? value : "…";
}
}  // namespace

Settings::Settings(const std::vector<std::pair<std::string, std::string>>& sets, const std::filesystem::path& working_directory,
                   ProblemList& problems)
    : problems_(problems)
{
    for (const auto& [name, value] : sets)
    {
        const std::string shown = "--set " + name + "=" + shown_value(value);
        problems.announce_file(shown);
        const auto source = std::make_shared<const YamlSource>(YamlSource{shown, working_directory, true});
        if (first_bad_byte(name + value))
        {
            problems.add({shown, 0, 0}, "it has a control character, or bytes that are not UTF-8");
            continue;
        }
        Path path = split(name, '.');
        if (std::ranges::find(path, "") != path.end() || path.size() > yaml_depth_limit)
        {
            problems.add({shown, 0, 0}, "expected NAME=VALUE or STAGE.OPTION=VALUE");
            continue;
        }
        settings_.push_back({std::move(path), parse_value(value, source, problems)});
    }
}

void Settings::set_vars(PipelineDocument& document, std::vector<MatrixAxis>& axes)
{
    for (const Setting& setting : settings_)
    {
        const std::string& name = setting.path.front();
        if (setting.path.size() > 1)
        {
            if (name != pipeline_components && !document.stages.find(name))
                problems_.add(setting.value, "unknown stage '" + name + "'" + suggestion(name, document.stages.keys()));
            continue;
        }
        const auto axis = std::ranges::find(axes, name, &MatrixAxis::var);
        if (axis != axes.end())
            set_axis(*axis, setting.value, problems_);
        else if (YamlNode::Entry* var = document.vars.find(name))
            var->value = setting.value;
        else if (document.stages.find(name))
            problems_.add(setting.value, "'" + name + "' is a stage: set one of its options, --set " + name + ".OPTION=VALUE");
        else if (document.complete)
            problems_.add(setting.value, "unknown var '" + name + "' in the pipeline" + suggestion(name, document.vars.keys()));
    }
}

void Settings::set_options(const std::string& name, YamlNode& stage, Variables& variables, TypeTable& types,
                           ProblemList& problems) const
{
    const std::vector<Setting> settings = settings_in(name, variables);
    if (!stage.is_map())
        return;
    // An option that decides what `auto` stands for must be in place before anything inside it is set.
    for (const bool inside : {false, true})
        for (const Setting& setting : settings)
            if ((setting.path.size() > 2) == inside)
                Setter(setting.path, setting.value, types, problems).set(stage, "stage", false, 1);
}

void Settings::set_components(YamlNode& components, Variables& variables, TypeTable& types, ProblemList& problems) const
{
    for (const Setting& setting : settings_in(std::string(pipeline_components), variables))
    {
        const std::string& kind = setting.path[1];
        const auto known = types.pipeline_components().find(kind);
        if (setting.path.size() > 2 && !components.find(kind) && known != types.pipeline_components().end())
            components.set(kind, yaml_from_value(known->second, setting.value));
        Setter(setting.path, setting.value, types, problems).set(components, kind, true, 1);
    }
}

std::vector<Settings::Setting> Settings::settings_in(const std::string& name, Variables& variables) const
{
    std::vector<Setting> settings;
    for (const Setting& setting : settings_)
        if (setting.path.size() > 1 && setting.path.front() == name)
            settings.push_back({setting.path, variables.substitute(setting.value)});
    return settings;
}

std::set<std::string> Settings::vars_in(const std::string& stage) const
{
    std::set<std::string> names;
    for (const Setting& setting : settings_)
        if (setting.path.size() > 1 && setting.path.front() == stage)
            names.merge(vars_named_in(setting.value));
    return names;
}

}  // namespace fresco::host
