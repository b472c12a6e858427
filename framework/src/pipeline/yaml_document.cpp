#include "pipeline/yaml_document.h"

#include "pipeline/yaml_text.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <fmt/format.h>
#include <sstream>
#include <unordered_map>

namespace fresco::host
{
namespace
{
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
        YamlNode node;
        node.kind = kind;
        const Position at = position(mark);
        node.line = at.line;
        node.column = at.column;
        node.source = source_;
        return node;
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
        Open level;
        level.node = make(kind, mark);
        open_.push_back(std::move(level));
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
        map.entry = {key.text, key.line, key.column, key.source, {}};
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
        {
            value.line = map.entry.line;
            value.column = map.entry.column;
        }
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
