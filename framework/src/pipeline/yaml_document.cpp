#include "pipeline/yaml_document.h"
#include "base/text.h"
#include "plugins/catalog.h"

#include <charconv>
#include <fmt/format.h>
#include <sstream>
#include <unordered_map>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

namespace fresco::host
{

std::optional<std::size_t> first_bad_byte(std::string_view text)
{
    for (std::size_t i = 0; i < text.size();)
    {
        const auto byte = static_cast<unsigned char>(text[i]);
        const std::size_t length = utf8_length(text, i);
        if (length == 0 || byte == 0x7F || (byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r'))
            return i;
        i += length;
    }
    return std::nullopt;
}

bool quote_is_closed(std::string_view quoted)
{
    const char quote = quoted.front();
    for (std::size_t i = 1; i < quoted.size(); ++i)
    {
        if (quote == '"' && quoted[i] == '\\')
            ++i;
        else if (quoted[i] == quote)
        {
            if (quote == '\'' && i + 1 < quoted.size() && quoted[i + 1] == '\'')
                ++i;
            else
                return true;
        }
    }
    return false;
}

namespace
{

std::string shortened(const std::string& text)
{
    constexpr std::size_t shown = 60;
    if (text.size() <= shown)
        return text;
    std::size_t end = shown;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U)
        --end;
    return text.substr(0, end) + "…";
}

bool is_decimal(char c)
{
    return c >= '0' && c <= '9';
}

bool all_digits(std::string_view text)
{
    return !text.empty() && std::all_of(text.begin(), text.end(), is_decimal);
}

/// ( . [0-9]+ | [0-9]+ ( . [0-9]* )? ) ( [eE] [-+]? [0-9]+ )?
bool looks_like_float(std::string_view text)
{
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return !text.empty() && (is_decimal(text.front()) || text.front() == '.') && error != std::errc::invalid_argument &&
           end == text.data() + text.size();
}

ResolvedScalar resolve_number(const std::string& text, std::string_view digits, bool negative)
{
    if (all_digits(digits))
    {
        if (digits.size() > 1 && digits.front() == '0')
            return {{},
                    "'" + text + "' begins with 0, which some readers take for octal: write it without the 0, or '" + text +
                        "' in quotes for text"};
        const std::string signed_digits = (negative ? "-" : "") + std::string(digits);
        std::int64_t number = 0;
        const auto [end, error] = std::from_chars(signed_digits.data(), signed_digits.data() + signed_digits.size(), number);
        if (error != std::errc())
            return {{}, "'" + shortened(text) + "' is too large for an integer"};
        return {Value(number), {}};
    }
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc() || end != digits.data() + digits.size())
        return {{}, "'" + shortened(text) + "' is out of the range of numbers"};
    return {Value(negative ? -number : number), {}};
}

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> words)
{
    return std::find(words.begin(), words.end(), text) != words.end();
}

struct Stop
{
};

/// What yaml-cpp's words mean to somebody who edits a file.
std::string explained(const std::string& message)
{
    if (message.find("illegal map value") != std::string::npos)
        return "a second ':' in one value, or a line indented deeper than its neighbors: put text with ': ' into quotes";
    if (message.find("end of map not found") != std::string::npos)
        return "this line does not continue the map above: check its indentation and its ':'";
    if (message.find("end of sequence not found") != std::string::npos)
        return "this line does not continue the list above: check its indentation and its '-'";
    if (message.find("end of map flow") != std::string::npos)
        return "a '{' is not closed by '}', or a ',' is missing";
    if (message.find("end of sequence flow") != std::string::npos)
        return "a '[' is not closed by ']', or a ',' is missing";
    return "not valid YAML: " + message;
}

/// Builds the tree and reports what a pipeline file must not hold.
class TreeBuilder final : public YAML::EventHandler
{
  public:
    TreeBuilder(const Text& text, std::shared_ptr<const YamlSource> source, ProblemList& problems)
        : text_(text), source_(std::move(source)), problems_(problems)
    {
    }

    YamlNode take_root() { return std::move(root_); }
    void expect_no_more() { expect_no_more_ = true; }
    /// Only of a document that could be read: an open '[' makes yaml-cpp see keys that do not exist.
    void report_odd_keys()
    {
        for (auto& [position, text] : odd_keys_)
            problems_.add(position, text);
    }

    Position position(std::size_t offset) const
    {
        if (source_->command_line)
            return {source_->name, 0, 0};
        const auto [line, column] = text_.place(offset);
        return {source_->name, line, column};
    }

    Position position(const YAML::Mark& mark) const { return position(text_.offset(mark)); }

    /// What is open when reading stops early still counts.
    void close_all()
    {
        while (!open_.empty())
            close();
    }

    void OnDocumentStart(const YAML::Mark& mark) override
    {
        if (!expect_no_more_)
            return;
        const bool second = text_.from(mark).substr(0, 3) == "---";
        problems_.add(position(mark), second ? "a second document begins here: a pipeline file holds one"
                                             : "there is text after the end of the document");
        throw Stop{};
    }

    void OnDocumentEnd() override {}

    void OnNull(const YAML::Mark& mark, YAML::anchor_t) override
    {
        // The mark of a null is the next token's; inside a map the key's place is used instead.
        deliver(make(YamlNode::Kind::null, mark));
    }

    void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override
    {
        problems_.add(position(mark), "aliases (*name) are not allowed in a pipeline file: repeat the text, or use a var");
        deliver(make(YamlNode::Kind::invalid, mark));
    }

    void OnAnchor(const YAML::Mark& mark, const std::string& name) override
    {
        problems_.add(position(mark), "anchors (&" + name + ") are not allowed in a pipeline file: use a var");
    }

    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& text) override
    {
        YamlNode node = make(YamlNode::Kind::scalar, mark);
        check_tag(mark, tag);
        const std::string_view written = text_.from(mark);
        if (!written.empty() && (written.front() == '"' || written.front() == '\'') && !quote_is_closed(written))
        {
            problems_.add(position(mark), "this quote is never closed");
            throw Stop{};
        }
        node.text = text;
        node.plain = tag == "?";
        deliver(std::move(node));
    }

    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override
    {
        open(YamlNode::Kind::list, mark, tag);
    }

    void OnSequenceEnd() override { close(); }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override
    {
        open(YamlNode::Kind::map, mark, tag);
    }

    void OnMapEnd() override { close(); }

  private:
    struct Open
    {
        YamlNode node;
        std::unordered_map<std::string, int> keys;  ///< With the line of each.
        YamlNode::Entry entry;                      ///< Its key is read, its value is next, when has_key.
        bool has_key = false;
        bool drop_entry = false;
    };

    YamlNode make(YamlNode::Kind kind, const YAML::Mark& mark)
    {
        if (++count_ > yaml_node_limit)
        {
            problems_.add(position(mark), fmt::format("more than {} values: not a pipeline file", yaml_node_limit));
            throw Stop{};
        }
        const Position at = position(mark);
        return YamlNode(kind, {at.line, at.column, source_});
    }

    void check_tag(const YAML::Mark& mark, const std::string& tag)
    {
        const bool implicit = (tag.empty() || tag == "?" || tag == "!") && text_.from(mark).substr(0, 1) != "!";
        if (!implicit)
            problems_.add(position(mark), "tags (" + (tag.empty() || tag == "?" ? std::string("!") : tag) +
                                              ") are not allowed in a pipeline file");
    }

    void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag)
    {
        check_tag(mark, tag);
        if (open_.size() >= yaml_depth_limit)
        {
            problems_.add(position(mark), fmt::format("nested deeper than {} levels", yaml_depth_limit));
            throw Stop{};
        }
        open_.emplace_back().node = make(kind, mark);
    }

    void close()
    {
        YamlNode node = std::move(open_.back().node);
        open_.pop_back();
        deliver(std::move(node));
    }

    void deliver(YamlNode node)
    {
        if (open_.empty())
            root_ = std::move(node);
        else if (open_.back().node.is_list())
            open_.back().node.items.push_back(std::move(node));
        else if (open_.back().has_key)
            deliver_value(open_.back(), std::move(node));
        else
            deliver_key(open_.back(), std::move(node));
    }

    void deliver_key(Open& map, YamlNode key)
    {
        map.has_key = true;
        map.drop_entry = true;
        map.entry = {key, key.text, {}};
        if (key.is_scalar() && key.plain && key.text == "<<")
            problems_.add(key.position(),
                          "merge keys (<<) are not allowed in a pipeline file: use 'base: FILE', or repeat the text");
        else if (!key.is_scalar())
        {
            if (key.is_valid())
                odd_keys_.emplace_back(key.position(), "a key must be a word, not " + key.summary());
        }
        else if (const auto [first, fresh] = map.keys.emplace(key.text, key.line); !fresh)
            problems_.add(key.position(),
                          fmt::format("the key '{}' appears twice; the first is on line {}", key.text, first->second));
        else
            map.drop_entry = false;
    }

    void deliver_value(Open& map, YamlNode value)
    {
        map.has_key = false;
        if (map.drop_entry)
            return;
        if (value.is_null())
            value.stand_at(map.entry);
        map.entry.value = std::move(value);
        map.node.entries.push_back(std::move(map.entry));
    }

    const Text& text_;
    std::shared_ptr<const YamlSource> source_;
    ProblemList& problems_;
    std::vector<Open> open_;
    YamlNode root_;
    std::vector<std::pair<Position, std::string>> odd_keys_;
    std::size_t count_ = 0;
    bool expect_no_more_ = false;
};

/// What was read, also where reading stopped early. An empty document stands at its beginning.
YamlNode finished_tree(TreeBuilder& tree, std::shared_ptr<const YamlSource> source)
{
    tree.close_all();
    YamlNode root = tree.take_root();
    if (!root.source)
    {
        root.source = std::move(source);
        root.line = root.source->command_line ? 0 : 1;
        root.column = root.line;
    }
    return root;
}

std::string_view without_byte_order_mark(std::string_view text)
{
    return text.substr(0, 3) == "\xEF\xBB\xBF" ? text.substr(3) : text;
}

}  // namespace

std::vector<std::string> YamlNode::keys() const
{
    std::vector<std::string> keys;
    std::ranges::transform(entries, std::back_inserter(keys), &Entry::key);
    return keys;
}

YamlNode::Entry* YamlNode::find(std::string_view key)
{
    const auto entry = std::ranges::find(entries, key, &Entry::key);
    return entry == entries.end() ? nullptr : &*entry;
}

void YamlNode::set(std::string_view key, YamlNode value)
{
    Entry* entry = find(key);
    if (!entry)
        entry = &entries.emplace_back();
    *entry = {value, std::string(key), std::move(value)};
}

std::string YamlNode::identity() const
{
    std::string result = std::to_string(static_cast<int>(kind)) + (plain ? 'p' : 'q') + std::to_string(text.size()) + ':' + text;
    for (const YamlNode& item : items)
        result += ',' + item.identity();
    for (const Entry& entry : entries)
        result += ';' + std::to_string(entry.key.size()) + ':' + entry.key + '=' + entry.value.identity();
    return result + ')';
}

void YamlNode::erase(std::string_view key)
{
    std::erase_if(entries, [&](const Entry& entry) { return entry.key == key; });
}

std::string YamlNode::summary() const
{
    switch (kind)
    {
    case Kind::null:
        return "nothing";
    case Kind::list:
        return "a list";
    case Kind::map:
        return "a map";
    case Kind::invalid:
        return "something unreadable";
    case Kind::scalar:
        break;
    }
    const ResolvedScalar resolved = resolve_scalar(*this);
    if (resolved.refusal.empty() && resolved.value.is_null())
        return "nothing";
    return resolved.refusal.empty() && !resolved.value.is_string() ? shortened(text) : "the text '" + shortened(text) + "'";
}

YamlNode yaml_from_value(const Value& value, const YamlNode& place)
{
    YamlNode node(YamlNode::Kind::null, place);
    node.origin = place.origin;
    if (value.is_list())
    {
        node.kind = YamlNode::Kind::list;
        for (const Value& item : value.as_list())
            node.items.push_back(yaml_from_value(item, place));
    }
    else if (value.is_map())
    {
        node.kind = YamlNode::Kind::map;
        for (const auto& [key, entry] : value.as_map())
            node.set(key, yaml_from_value(entry, place));
    }
    else if (!value.is_null())
    {
        node.kind = YamlNode::Kind::scalar;
        node.plain = !value.is_string();
        if (value.is_string())
            node.text = value.as_string();
        else if (value.is_bool())
            node.text = value.as_bool() ? "true" : "false";
        else
            node.text = value.is_int() ? std::to_string(value.as_int()) : number_text(value.as_double());
    }
    return node;
}

ResolvedScalar resolve_scalar(const YamlNode& scalar)
{
    const std::string& text = scalar.text;
    if (!scalar.plain)
        return {Value(text), {}};
    if (is_one_of(text, {"", "~", "null", "Null", "NULL"}))
        return {};
    if (is_one_of(text, {"true", "True", "TRUE"}))
        return {Value(true), {}};
    if (is_one_of(text, {"false", "False", "FALSE"}))
        return {Value(false), {}};
    std::string_view digits = text;
    const bool has_sign = digits.front() == '-' || digits.front() == '+';
    const bool negative = digits.front() == '-';
    if (has_sign)
        digits.remove_prefix(1);
    if (is_one_of(digits, {".inf", ".Inf", ".INF"}) || (!has_sign && is_one_of(digits, {".nan", ".NaN", ".NAN"})))
        return {{}, "'" + text + "' is not a finite number"};
    if (looks_like_float(digits))
        return resolve_number(text, digits, negative);
    if (digits.size() > 2 && digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'o') &&
        std::all_of(digits.begin() + 2, digits.end(),
                    [](char c) { return is_decimal(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }))
        return {{}, "'" + text + "' is a number to some readers and text to others: write it in decimal, or in quotes for text"};
    return {Value(text), {}};
}

YamlNode parse_yaml(std::string_view text, std::shared_ptr<const YamlSource> source, ProblemList& problems, bool& complete)
{
    text = without_byte_order_mark(text);
    const Text lines(text);
    TreeBuilder tree(lines, source, problems);
    complete = false;
    if (text.size() > yaml_size_limit)
    {
        problems.add({source->name, 0, 0}, "larger than 1 MiB: not a pipeline file");
        return {};
    }
    if (const auto bad = first_bad_byte(text))
    {
        problems.add(tree.position(*bad), "invalid UTF-8: save the file as UTF-8");
        return {};
    }
    if (const auto line = lines.first_longer_than(yaml_line_limit))
    {
        problems.add(tree.position(*line), fmt::format("a line of more than {} bytes: break it", yaml_line_limit));
        return {};
    }
    std::istringstream stream{std::string(text)};
    try
    {
        YAML::Parser parser(stream);
        if (parser.HandleNextDocument(tree))
        {
            tree.expect_no_more();
            parser.HandleNextDocument(tree);
        }
        tree.report_odd_keys();
        complete = true;
    }
    catch (const Stop&)
    {
    }
    catch (const YAML::Exception& error)
    {
        const std::string_view line = lines.line(error.mark);
        const std::size_t indentation = std::min(line.find_first_not_of(" \t"), line.size());
        if (const std::size_t tab = line.substr(0, indentation).find('\t'); tab != std::string_view::npos)
        {
            YAML::Mark at = error.mark;
            at.column = static_cast<int>(tab);
            problems.add(tree.position(at), "a tab cannot indent a line: use spaces");
            return finished_tree(tree, std::move(source));
        }
        const bool bare_var = line.find(": ${") != std::string_view::npos || line.find("[${") != std::string_view::npos;
        problems.add(tree.position(error.mark),
                     explained(error.msg) + (bare_var ? "; inside { } and [ ] a \"${var}\" needs quotes" : ""));
    }
    return finished_tree(tree, std::move(source));
}

}  // namespace fresco::host
