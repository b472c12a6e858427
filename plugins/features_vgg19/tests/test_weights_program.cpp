#include "catch.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/value.h>
#include <fresco/weights/sha256.h>
#include <fresco/weights/state_dict.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <sys/wait.h>
#include <thread>

namespace fs = std::filesystem;

namespace
{

struct Finished
{
    int code = -1;
    std::string out;
    std::string err;
};

std::string quoted(const std::string& word)
{
    std::string result = "'";
    for (const char c : word)
        result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// A folder in which the program runs.
class Workplace
{
  public:
    std::string path = std::getenv("PATH");

    fs::path file(const std::string& name) const { return folder_.path() / name; }
    Finished run(const std::vector<std::string>& words) const
    {
        std::string command = "cd " + quoted(file(".")) + " && PATH=" + quoted(path) +
                              " XDG_CACHE_HOME=" + quoted(file("cache")) + " " + quoted(FRESCO_WEIGHTS);
        for (const auto& word : words)
            command += " " + quoted(word);
        const int status = std::system((command + " >out 2>err").c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, fresco::read_text_file(file("out")),
                fresco::read_text_file(file("err"))};
    }

  private:
    fresco::testing::TemporaryFolder folder_;
};

bool contains(const std::string& text, const std::string& part)
{
    const bool found = text.find(part) != std::string::npos;
    if (!found)
        UNSCOPED_INFO("\"" << part << "\" is not in:\n" << text);
    return found;
}

/// conv1_1 of VGG-19, element i being i / 64, and one tensor of the classifier.
std::vector<std::byte> small_weights(const std::map<std::string, std::string>& metadata = {})
{
    std::vector<float> values(64 * 27);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(i) / 64;
    const auto all = std::as_bytes(std::span(values));
    using fresco::weights::ElementType;
    const std::vector<fresco::weights::TensorView> tensors{{"features.0.weight", ElementType::float32, {64, 3, 3, 3}, all},
                                                           {"features.0.bias", ElementType::float32, {64}, all.first(256)},
                                                           {"classifier.0.bias", ElementType::float32, {2}, all.first(8)}};
    return fresco::weights::to_safetensors(tensors, metadata);
}

/// Python's server with one file, until the end of the test.
class Server
{
  public:
    Server(const Workplace& place, const std::vector<std::byte>& contents, const std::vector<std::string>& options = {})
        : log_(place.file("requests"))
    {
        const auto file = place.file("served");
        const auto port = place.file("port");
        fs::remove(port);
        fresco::write_file(file, contents);
        std::string command = quoted(FRESCO_PYTHON);
        for (const std::string& word : {std::string(FRESCO_RANGE_SERVER), file.string(), port.string(), log_.string()})
            command += " " + quoted(word);
        for (const auto& option : options)
            command += " " + quoted(option);
        const auto number = quoted(place.file("pid"));
        REQUIRE(std::system((command + " >/dev/null 2>&1 & echo $! >" + number).c_str()) == 0);
        for (int i = 0; i < 2000 && !fs::exists(port); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        REQUIRE(fs::exists(port));
        pid_ = std::stoi(fresco::read_text_file(place.file("pid")));
        address_ = "http://127.0.0.1:" + fresco::read_text_file(port) + "/";
    }
    ~Server() { kill(pid_, SIGKILL); }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::string url(const std::string& name = "w.pth") const { return address_ + name; }
    /// Requests so far, and forgets them.
    std::string requests() const
    {
        const std::string text = fs::exists(log_) ? fresco::read_text_file(log_) : "";
        fs::remove(log_);
        return text;
    }

  private:
    fs::path log_;
    pid_t pid_ = -1;
    std::string address_;
};

}  // namespace

TEST_CASE("weights inspect says what a file holds")
{
    Workplace place;
    const auto bytes = small_weights();
    fresco::write_file(place.file("w.safetensors"), bytes);
    const Finished text = place.run({"inspect", "w.safetensors"});
    REQUIRE(text.code == 0);
    for (const std::string part : {"safetensors", "conv1_1 to conv1_1", "features.0.weight", "64 x 3 x 3 x 3", "RGB in [0,1]",
                                   "zero", "not used: classifier.0.bias"})
        CHECK(contains(text.out, part));
    const Finished json = place.run({"inspect", "--json", "w.safetensors"});
    REQUIRE(json.code == 0);
    const auto value = fresco::parse_json(json.out);
    CHECK(value.at("sha256").as_string() == fresco::weights::sha256(bytes));
    CHECK(value.at("tensors").as_list().size() == 2);
    CHECK(value.at("tensors").as_list()[0].at("shape").as_list().size() == 4);
    CHECK(value.at("scale").as_string() == "other");
    CHECK(value.at("names").as_string() == "torchvision");

    fresco::write_file(place.file("bad.pth"), std::string("nothing of the kind"));
    CHECK(place.run({"inspect", "bad.pth"}).code == 1);
    CHECK(place.run({"inspect", "none.pth"}).code == 3);
    CHECK(place.run({}).code == 2);
    CHECK(place.run({"get", "vgg16"}).code == 2);
}

TEST_CASE("weights convert writes the convolutions with what they are")
{
    Workplace place;
    const auto bytes = small_weights();
    fresco::write_file(place.file("w.safetensors"), bytes);
    REQUIRE(place.run({"convert", "w.safetensors", "out.safetensors", "--input", "bgr", "--scale", "raw"}).code == 0);
    const auto file = fresco::weights::read_weights(place.file("out.safetensors"));
    CHECK(file.contents.tensors.size() == 2);
    CHECK(file.contents.metadata.at("source_sha256") == fresco::weights::sha256(bytes));
    CHECK(contains(file.contents.metadata.at("input"), "BGR"));
    CHECK(file.contents.metadata.at("padding") == "zero");
    const auto* weight = file.contents.find("features.0.weight");
    REQUIRE(weight != nullptr);
    CHECK(fresco::weights::to_float32(*weight, "w")[65] == 65.0F / 64);
    const auto value = fresco::parse_json(place.run({"inspect", "--json", "out.safetensors"}).out);
    CHECK(value.at("scale").as_string() == "raw");
    CHECK(contains(place.run({"inspect", "out.safetensors"}).out, "scale       raw"));
    CHECK(place.run({"convert", "w.safetensors", "out.safetensors", "--input", "yuv"}).code == 2);
    CHECK(place.run({"convert", "w.safetensors", "nowhere/out.safetensors"}).code == 1);

    REQUIRE(place.run({"convert", "w.safetensors", "half.safetensors", "--until", "relu1_1", "--half"}).code == 0);
    const auto half = fresco::weights::read_weights(place.file("half.safetensors"));
    const auto* halved = half.contents.find("features.0.weight");
    REQUIRE(halved != nullptr);
    CHECK(halved->type == fresco::weights::ElementType::float16);
    CHECK(fresco::weights::to_float32(*halved, "w")[65] == 65.0F / 64);
    const Finished beyond = place.run({"convert", "w.safetensors", "out.safetensors", "--until", "relu4_1"});
    CHECK(beyond.code == 1);
    CHECK(contains(beyond.err, "relu1_1 to relu1_1"));
}

TEST_CASE("weights get fetches a file once, checks it and goes on where it was interrupted")
{
    Workplace place;
    const auto bytes = small_weights();
    const std::string hash = fresco::weights::sha256(bytes);
    const Server server(place, bytes, {"cut=3000"});
    const std::vector<std::string> get{"get", "vgg19", "--url", server.url(), "--sha256", hash};

    const Finished broken = place.run(get);
    CHECK(broken.code == 1);
    CHECK(contains(broken.err, "run again to resume"));
    CHECK(contains(server.requests(), "/w.pth None"));
    const fs::path kept = place.file("cache") / "fresco" / "weights" / "vgg19-dcbb9e9d.pth";
    CHECK_FALSE(fs::exists(kept));
    CHECK(fs::file_size(kept.string() + ".fresco-part") == 3000);

    const Finished whole = place.run(get);
    CHECK(whole.code == 0);
    CHECK(whole.out == kept.string() + "\n");
    CHECK(contains(server.requests(), "bytes=3000-"));
    CHECK(fresco::read_file(kept) == bytes);
    CHECK_FALSE(fs::exists(kept.string() + ".fresco-part"));

    CHECK(place.run(get).code == 0);
    CHECK(server.requests().empty());
    // Ended between the last byte and the new name.
    fs::rename(kept, kept.string() + ".fresco-part");
    CHECK(place.run(get).code == 0);
    CHECK(server.requests().empty());
    // Another file's beginning, and more of it than there is: from the start.
    for (const std::size_t size : {std::size_t{100}, bytes.size() + 5})
    {
        fs::remove(kept);
        fresco::write_file(kept.string() + ".fresco-part", std::string(size, 'x'));
        CHECK(place.run(get).code == 0);
        CHECK(fresco::read_file(kept) == bytes);
    }
}

TEST_CASE("weights get refuses what is not the file")
{
    Workplace place;
    const auto bytes = small_weights();
    const std::string hash = fresco::weights::sha256(bytes);
    const Server server(place, bytes, {"ranges=no"});
    const auto get = [&](const std::vector<std::string>& more)
    {
        std::vector<std::string> arguments{"get", "vgg19", "--to", "w.pth"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return place.run(arguments);
    };
    // Not the published file: the beginning of its SHA-256 is another.
    const Finished other = get({"--url", server.url()});
    CHECK(other.code == 1);
    CHECK((contains(other.err, hash) && contains(other.err, "dcbb9e9d")));
    CHECK_FALSE((fs::exists(place.file("w.pth")) || fs::exists(place.file("w.pth.fresco-part"))));
    const Finished missing = get({"--url", server.url("missing")});
    CHECK(missing.code == 1);
    CHECK(contains(missing.err, "404"));
    CHECK_FALSE(fs::exists(place.file("w.pth.fresco-part")));
    CHECK(contains(get({"--url", "file:///etc/passwd"}).err, "http://"));
    CHECK(contains(get({"--sha256", "dcbb"}).err, "8 to 64"));
    // A server that knows no ranges: from the start.
    fresco::write_file(place.file("w.pth.fresco-part"), std::span(bytes).first(1000));
    CHECK(get({"--url", server.url(), "--sha256", hash}).code == 0);
    CHECK(fresco::read_file(place.file("w.pth")) == bytes);
    // What is there and different is left alone.
    fresco::write_file(place.file("w.pth"), std::string("mine"));
    const Finished mine = get({"--url", server.url(), "--sha256", hash});
    CHECK(mine.code == 1);
    CHECK(contains(mine.err, "remove it"));
    CHECK(fresco::read_text_file(place.file("w.pth")) == "mine");
    place.path = "/nowhere";
    fs::remove(place.file("w.pth"));
    CHECK(contains(get({"--url", server.url(), "--sha256", hash}).err, "curl is not installed"));
}

TEST_CASE("the words of a command line are offered as fresco asks for them")
{
    const Workplace place;
    const auto offered = [&](std::vector<std::string> words)
    {
        words.insert(words.begin(), "internal-complete");
        return place.run(words).out;
    };
    CHECK(offered({""}) == "convert\nget\ninspect\n");
    CHECK(offered({"ins"}) == "inspect\n");
    CHECK(offered({"get", ""}) == "vgg19\n");
    CHECK(offered({"inspect", "--j"}) == "--json\n");
    CHECK(offered({"inspect", ""}) == ":files\n");
    CHECK(offered({"nothing", ""}).empty());
}
