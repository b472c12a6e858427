#pragma once

#include <fresco/port.h>
#include <fresco/texture.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// \file Rules that choose a texture for each part of a surface: {floor: keep, walls: waves, "*": {texture: night, strength:
/// 0.7}}.

namespace fresco
{

/// In a rule: the stage's first texture, unchanged.
inline constexpr std::string_view kept_texture = "keep";
/// The part that stands for all parts without a rule of their own.
inline constexpr std::string_view other_parts = "*";

struct TextureRule
{
    std::string texture;  ///< A port, or kept_texture.
    double strength = 1;

    bool keeps() const { return texture == kept_texture; }
};

/// The textures that the rules name, as check_value gives them, each once and in the order of their names.
std::vector<std::string> textures_named(const Value& rules);

/// Option of the kind texture_rules. Each texture that a rule names becomes an input port of that name when it is configured.
class TextureRules final : public Parameter
{
  public:
    /// `parts_of`: the input whose parts the rules are for. `fresco check` refuses rules for others, where the stage that makes
    /// them declares their names.
    TextureRules(Configurable* owner, std::string name, std::string parts_of, std::string help);

    const std::map<std::string, TextureRule>& operator*() const { return rules_; }
    const std::map<std::string, std::unique_ptr<Input<Texture>>>& textures() const { return textures_; }

  private:
    void set(const Value& value, ComponentFactory& factory) override;

    Configurable* owner_;
    std::map<std::string, TextureRule> rules_;
    std::map<std::string, std::unique_ptr<Input<Texture>>> textures_;
};

}  // namespace fresco
