#include "pipeline/yaml_document.h"
#include "base/common.h"
#include "base/text.h"
#include "plugins/catalog.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <sstream>
#include <unordered_map>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

namespace fresco::host
{

namespace
{

/// Columns of a text in a message.
constexpr std::size_t shown_columns = 60;

/// Whether a quoted scalar that begins `quoted` ends in it: yaml-cpp takes the end of the file for the closing quote.
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

bool is_decimal(char c)
{
    return c >= '0' && c <= '9';
}

/// The value of a text that is a number; nothing if `digits`, the text without its sign, is not
/// ( . [0-9]+ | [0-9]+ ( . [0-9]* )? ) ( [eE] [-+]? [0-9]+ )?
std::optional<ResolvedScalar> resolve_number(const std::string& text, std::string_view digits)
{
    const char* const end = text.data() + text.size();
    double number = 0;
    const auto [number_end, error] = std::from_chars(digits.data(), end, number);
    if (digits.empty() || !(is_decimal(digits.front()) || digits.front() == '.') || error == std::errc::invalid_argument ||
        number_end != end)
        return std::nullopt;
    if (!std::ranges::all_of(digits, is_decimal))
    {
        if (error != std::errc())
            return ResolvedScalar{{}, "'" + shortened(text, shown_columns) + "' is out of the range of numbers"};
        return ResolvedScalar{text.front() == '-' ? -number : number, {}};
    }
    if (digits.size() > 1 && digits.front() == '0')
        return ResolvedScalar{{}, "'" + text + "' begins with 0, which is octal to some readers: leave it out, or use quotes"};
    std::int64_t integer = 0;
    if (std::from_chars(text.front() == '-' ? text.data() : digits.data(), end, integer).ec != std::errc())
        return ResolvedScalar{{}, "'" + shortened(text, shown_columns) + "' is too large for an integer"};
    return ResolvedScalar{integer, {}};
}

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> words)
{
    return std::ranges::find(words, text) != words.end();
}

struct Stop
{
};

/// Explains yaml-cpp's words to somebody who edits a file.
std::string explained(const std::string& message)
{
    static const std::pair<const char*, const char*> meanings[] = {
        {"illegal map value",
         "a second ':' in one value, or a line indented deeper than its neighbors: put text with ': ' into quotes"},
        {"end of map not found", "this line does not continue the map above: check its indentation and its ':'"},
        {"end of sequence not found", "this line does not continue the list above: check its indentation and its '-'"},
        {"end of map flow", "a '{' is not closed by '}', or a ',' is missing"},
        {"end of sequence flow", "a '[' is not closed by ']', or a ',' is missing"}};
    for (const auto& [words, meaning] : meanings)
        if (message.find(words) != std::string::npos)
            return meaning;
    return "not valid YAML: " + message;
}

/// Builds the tree and reports what a pipeline file must not hold.
class TreeBuilder final : public YAML::EventHandler
{
  public:
    TreeBuilder(std::string_view text, std::shared_ptr<const YamlSource> source, ProblemList& problems)
        : text_(text), source_(std::move(source)), problems_(problems)
    {
    }

    void expect_no_more() { expect_no_more_ = true; }
    /// Only of a document that could be read: an open '[' makes yaml-cpp see keys that do not exist.
    void report_odd_keys()
    {
        for (auto& [position, text] : odd_keys_)
            problems_.add(position, text);
    }

    /// The nodes read, also if reading stopped early: open ones still count. An empty document stands at its
    /// beginning.
    YamlNode take()
    {
        while (!open_.empty())
            close();
        const int first = source_->command_line ? 0 : 1;
        if (!root_.source)
            root_.stand_at({first, first, source_});
        return std::move(root_);
    }

    void report(std::size_t offset, const std::string& text)
    {
        const auto lines = std::ranges::count(text_.substr(0, offset), '\n');
        problems_.add(place(offset, static_cast<int>(lines)), text);
    }

    void report(const YAML::Mark& mark, const std::string& text) { problems_.add(place(mark), text); }
    void report_syntax(const YAML::Exception& error)
    {
        const std::size_t begin = line_begin(offset_of(error.mark));
        const std::string_view line = text_.substr(begin, text_.find('\n', begin) - begin);
        const std::string_view indentation = line.substr(0, line.find_first_not_of(" \t"));
        const bool bare_var = line.find(": ${") != std::string_view::npos || line.find("[${") != std::string_view::npos;
        if (const std::size_t tab = indentation.find('\t'); tab != std::string_view::npos)
            report(begin + tab, "a tab cannot indent a line: use spaces");
        else
            report(error.mark, explained(error.msg) + (bare_var ? "; inside { } and [ ] a \"${var}\" needs quotes" : ""));
    }

    void OnDocumentStart(const YAML::Mark& mark) override
    {
        if (!expect_no_more_)
            return;
        report(mark, text_.substr(offset_of(mark)).starts_with("---") ? "a second document begins here: a pipeline file holds one"
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
        report(mark, "aliases (*name) are not allowed in a pipeline file: repeat the text, or use a var");
        deliver(make(YamlNode::Kind::invalid, mark));
    }

    void OnAnchor(const YAML::Mark& mark, const std::string& name) override
    {
        report(mark, "anchors (&" + name + ") are not allowed in a pipeline file: use a var");
    }

    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& text) override
    {
        YamlNode node = make(YamlNode::Kind::scalar, mark);
        check_tag(mark, tag);
        const std::string_view written = text_.substr(offset_of(mark));
        if (!written.empty() && (written.front() == '"' || written.front() == '\'') && !quote_is_closed(written))
        {
            report(mark, "this quote is never closed");
            throw Stop{};
        }
        if (first_bad_byte(text) || text.find('\r') != std::string::npos)
        {
            report(mark, "'" + shortened(text, shown_columns) + "' has a control character: leave it out");
            node.kind = YamlNode::Kind::invalid;
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
            report(mark, fmt::format("more than {} values: not a pipeline file", yaml_node_limit));
            throw Stop{};
        }
        return YamlNode(kind, place(mark));
    }

    std::size_t offset_of(const YAML::Mark& mark) const
    {
        // At the end of the text, yaml-cpp resets the column but keeps the position.
        const std::size_t begin = line_begin(std::min(static_cast<std::size_t>(std::max(mark.pos, 0)), text_.size()));
        return std::min(begin + static_cast<std::size_t>(std::max(mark.column, 0)), text_.size());
    }

    std::size_t line_begin(std::size_t offset) const { return text_.substr(0, offset).rfind('\n') + 1; }
    YamlPlace place(const YAML::Mark& mark) const { return place(offset_of(mark), mark.line); }
    /// `line` counts from 0; the column, in characters, is counted here.
    YamlPlace place(std::size_t offset, int line) const
    {
        if (source_->command_line)
            return {0, 0, source_};
        const std::size_t begin = line_begin(offset);
        const auto characters = std::ranges::count_if(text_.substr(begin, offset - begin), begins_character);
        return {std::max(line, 0) + 1, static_cast<int>(characters) + 1, source_};
    }

    void check_tag(const YAML::Mark& mark, const std::string& tag)
    {
        const bool implicit = (tag.empty() || tag == "?" || tag == "!") && !text_.substr(offset_of(mark)).starts_with('!');
        if (!implicit)
            report(mark,
                   "tags (" + (tag.empty() || tag == "?" ? std::string("!") : tag) + ") are not allowed in a pipeline file");
    }

    void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag)
    {
        check_tag(mark, tag);
        if (open_.size() >= yaml_depth_limit)
        {
            report(mark, fmt::format("nested deeper than {} levels", yaml_depth_limit));
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
            problems_.add(key, "merge keys (<<) are not allowed in a pipeline file: use 'base: FILE', or repeat the text");
        else if (!key.is_scalar())
        {
            if (key.is_valid())
                odd_keys_.emplace_back(key, "a key must be a word, not " + key.summary());
        }
        else if (key.text.find_first_of("\n\r\t") != std::string::npos)
            problems_.add(key, "the key '" + shortened(key.text, shown_columns) +
                                   "' has an end of line or a tab: write it in one line");
        else if (const auto [first, fresh] = map.keys.emplace(key.text, key.line); !fresh)
            problems_.add(key, fmt::format("the key '{}' appears twice; the first is on line {}", key.text, first->second));
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

    std::string_view text_;
    std::shared_ptr<const YamlSource> source_;
    ProblemList& problems_;
    std::vector<Open> open_;
    YamlNode root_;
    std::vector<std::pair<Position, std::string>> odd_keys_;
    std::size_t count_ = 0;
    bool expect_no_more_ = false;
};

}  // namespace

std::vector<std::string> YamlNode::keys() const
{
    return each(entries, &Entry::key);
}

YamlNode::Entry* YamlNode::find(std::string_view key)
{
    const auto entry = std::ranges::find(entries, key, &Entry::key);
    return entry == entries.end() ? nullptr : &*entry;
}

YamlNode& YamlNode::set(std::string_view key, YamlNode value)
{
    Entry* entry = find(key);
    if (!entry)
        entry = &entries.emplace_back();
    *entry = {value, std::string(key), std::move(value)};
    return entry->value;
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
    return resolved.refusal.empty() && !resolved.value.is_string() ? shortened(text, shown_columns)
                                                                   : "the text '" + shortened(text, shown_columns) + "'";
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
        node.text = value.is_string() ? value.as_string() : to_json(value);
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
    const bool has_sign = text.front() == '-' || text.front() == '+';
    const std::string_view digits = std::string_view(text).substr(has_sign ? 1 : 0);
    if (is_one_of(digits, {".inf", ".Inf", ".INF"}) || (!has_sign && is_one_of(digits, {".nan", ".NaN", ".NAN"})))
        return {{}, "'" + text + "' is not a finite number"};
    if (const auto number = resolve_number(text, digits))
        return *number;
    if (digits.size() > 2 && (digits.starts_with("0x") || digits.starts_with("0o")) &&
        digits.find_first_not_of("0123456789abcdefABCDEF", 2) == std::string_view::npos)
        return {{}, "'" + text + "' is a number to some readers and text to others: write it in decimal, or in quotes for text"};
    return {Value(text), {}};
}

YamlNode parse_yaml(std::string_view text, std::shared_ptr<const YamlSource> source, ProblemList& problems, bool& complete)
{
    if (text.starts_with("\xEF\xBB\xBF"))
        text.remove_prefix(3);
    TreeBuilder tree(text, source, problems);
    complete = false;
    if (text.size() > yaml_size_limit)
    {
        problems.add({source->name, 0, 0}, "larger than 1 MiB: not a pipeline file");
        return {};
    }
    if (const auto bad = first_bad_byte(text))
    {
        tree.report(*bad, "invalid UTF-8 or a control character: remove it, and save the file as UTF-8");
        return {};
    }
    for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1)
        if (end = std::min(text.find('\n', begin), text.size()); end - begin > yaml_line_limit)
        {
            tree.report(begin, fmt::format("a line of more than {} bytes: break it", yaml_line_limit));
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
        tree.report_syntax(error);
    }
    return tree.take();
}

}  // namespace fresco::host
