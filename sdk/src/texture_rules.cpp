#include <fresco/texture_rules.h>

#include <set>

namespace fresco
{

std::vector<std::string> textures_named(const Value& rules)
{
    std::set<std::string> names;
    for (const auto& [part, rule] : rules.as_map())
        if (const std::string& name = rule.at("texture").as_string(); name != kept_texture)
            names.insert(name);
    return {names.begin(), names.end()};
}

TextureRules::TextureRules(Configurable* owner, std::string name, std::string parts_of, std::string help)
    : Parameter(owner, {.name = std::move(name),
                        .kind = OptionKind::texture_rules,
                        .required = true,
                        .parts_of = std::move(parts_of),
                        .help = std::move(help)}),
      owner_(owner)
{
}

void TextureRules::set(const Value& value, ComponentFactory&)
{
    rules_.clear();
    for (const auto& [part, rule] : value.as_map())
        rules_[part] = {rule.at("texture").as_string(), rule.at("strength").as_double()};
    for (const std::string& name : textures_named(value))
        textures_[name] = std::make_unique<Input<Texture>>(owner_, name, "The texture '" + name + "' of the rules");
}

}  // namespace fresco
