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

std::string joined(const Path& path, std::size_t count)
{
    return fmt::format("{}", fmt::join(std::span(path).first(count), "."));
}

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

/// Puts one value at a path inside the configuration of a stage or component.
class Setter
{
  public:
    Setter(const Path& path, const YamlNode& value, TypeTable& types, ProblemList& problems)
        : path_(path), value_(value), types_(types), problems_(problems)
    {
    }

    void set_in_stage(YamlNode& stage)
    {
        if (path_[1] == "input")
            set_input(stage);
        else
            set_in_config(stage, "stage", 1);
    }

    /// A kind that is not there is reported when it is checked.
    void set_in_components(YamlNode& components)
    {
        const std::string& kind = path_[1];
        const auto known = types_.pipeline_components().find(kind);
        if (path_.size() == 2 || known == types_.pipeline_components().end())
        {
            components.set(kind, value_);
            return;
        }
        const YamlNode::Entry* written = components.find(kind);
        YamlNode config = written ? written->value : yaml_from_value(known->second, value_);
        set_in_component(config, kind, 2);
        components.set(kind, std::move(config));
    }

  private:
    void report(const std::string& text) { problems_.add(value_, text); }

    void set_input(YamlNode& stage)
    {
        YamlNode* node = &stage;
        for (std::size_t i = 1; i + 1 < path_.size(); ++i)
        {
            YamlNode::Entry* entry = node->find(path_[i]);
            YamlNode& inner = entry ? entry->value : node->set(path_[i], YamlNode(YamlNode::Kind::map, {0, 0, value_.source}));
            if (!inner.is_map())
                return report("'" + joined(path_, i + 1) + "' is " + inner.summary() + " in the file, not a map with '" +
                              path_[i + 1] + "': set it as a whole");
            node = &inner;
        }
        node->set(path_.back(), value_);
    }

    /// `config` holds options (and `type`); path_[at] names one of them.
    void set_in_config(YamlNode& config, std::string_view kind, std::size_t at)
    {
        if (at + 1 == path_.size())
        {
            if (path_[at] == "type")
                drop_options(config, kind);
            config.set(path_[at], value_);
            return;
        }
        const std::optional<std::string> name = type_named_by(config, joined(path_, at), nullptr);
        const KnownType type = name ? types_.find(*name, kind) : KnownType{};
        if (!type)
            return;  // The type itself is reported elsewhere.
        const OptionDeclaration* option = type.declaration->option(path_[at]);
        if (!option)
            return report("'" + joined(path_, at) + "' (" + *name + ") has no option '" + path_[at] + "'" +
                          suggestion(path_[at], type.declaration->option_names()));
        if (!option->is_slot())
            return report("the option '" + joined(path_, at + 1) + "' is not a component and has no '" + path_[at + 1] +
                          "' inside: it accepts " + option->accepted());
        expand_auto(*type.declaration, config);
        YamlNode* slot = written_out(config, *option);
        if (!slot)
            return report("'" + joined(path_, at + 1) + "' holds no component yet: set " + joined(path_, at + 1) + ".type first");
        if (option->kind == OptionKind::component)
            set_in_component(*slot, option->component_kind, at + 1);
        else
            set_in_named(*slot, option->component_kind, at + 1);
    }

    /// The value of a slot as written, else its default. A slot without either can be given a type.
    YamlNode* written_out(YamlNode& config, const OptionDeclaration& option)
    {
        if (YamlNode::Entry* written = config.find(option.name))
            return &written->value;
        YamlNode value = yaml_from_value(option.default_value, config);
        if (value.is_null() && option.kind == OptionKind::component && path_.back() != "type")
            return nullptr;
        if (value.is_null())
            value.kind = YamlNode::Kind::map;
        return &config.set(option.name, std::move(value));
    }

    void set_in_component(YamlNode& config, std::string_view kind, std::size_t at)
    {
        if (config.is_scalar())
        {
            YamlNode map = config;
            map.kind = YamlNode::Kind::map;
            map.text.clear();
            map.set("type", config);
            config = std::move(map);
        }
        if (config.is_map())
            set_in_config(config, kind, at);
    }

    void set_in_named(YamlNode& named, std::string_view kind, std::size_t at)
    {
        if (!named.is_map())
            return report("'" + joined(path_, at) + "' is " + named.summary() + " in the file, not a map of components");
        if (at + 1 == path_.size())
        {
            named.set(path_[at], value_);
            return;
        }
        if (!named.find(path_[at]))
        {
            if (path_.back() != "type" || at + 2 != path_.size())
                return report("there is no '" + joined(path_, at + 1) + "'" + suggestion(path_[at], named.keys()));
            named.set(path_[at], YamlNode(YamlNode::Kind::map, {0, 0, value_.source}));
        }
        set_in_component(named.find(path_[at])->value, kind, at + 1);
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
        if (has_control_characters(name + value))
        {
            problems.add({shown, 0, 0}, "control characters are not allowed");
            continue;
        }
        Path path = split(name, '.');
        if (std::ranges::find(path, "") != path.end())
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
                Setter(setting.path, setting.value, types, problems).set_in_stage(stage);
}

void Settings::set_components(YamlNode& components, Variables& variables, TypeTable& types, ProblemList& problems) const
{
    for (const Setting& setting : settings_in(std::string(pipeline_components), variables))
        Setter(setting.path, setting.value, types, problems).set_in_components(components);
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
