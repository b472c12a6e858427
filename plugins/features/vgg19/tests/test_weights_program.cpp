#include "started_program.h"

#include "../weights_program/download.h"

#include <fresco/testing.h>
#include <fresco/weights/sha256.h>
#include <fresco/weights/state_dict.h>

#include <span>

namespace
{

/// A folder in which the program runs.
class Workplace
{
  public:
    Workplace() { environment["XDG_CACHE_HOME"] = file("cache"); }

    std::map<std::string, std::string> environment;

    fs::path file(const std::string& name) const { return folder_.path() / name; }
    Finished run(std::vector<std::string> words) const
    {
        words.insert(words.begin(), FRESCO_WEIGHTS);
        return Background(words, environment, folder_.path(), file("out"), file("err")).wait();
    }

  private:
    fresco::testing::TemporaryFolder folder_;
};

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
        fs::remove(place.file("port"));
        fresco::write_file(place.file("served"), contents);
        std::vector<std::string> words{FRESCO_PYTHON, FRESCO_RANGE_SERVER, place.file("served"), place.file("port"), log_};
        words.insert(words.end(), options.begin(), options.end());
        process_.emplace(words, std::map<std::string, std::string>(), place.file("."), place.file("server_out"),
                         place.file("server_err"));
        wait_until([&] { return fs::exists(place.file("port")); });
        address_ = "http://127.0.0.1:" + fresco::read_text_file(place.file("port")) + "/";
    }

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
    std::optional<Background> process_;
    std::string address_;
};

struct WithPlace
{
    Workplace place;
    std::vector<std::byte> bytes = small_weights();
    std::string hash = fresco::weights::sha256(bytes);
};

}  // namespace

TEST_CASE_METHOD(WithPlace, "weights inspect says what a file holds")
{
    fresco::write_file(place.file("w.safetensors"), bytes);
    const Finished text = place.run({"inspect", "w.safetensors"});
    REQUIRE(text.code == 0);
    for (const std::string part : {"safetensors", "conv1_1 to conv1_1", "features.0.weight", "64 x 3 x 3 x 3", "RGB in [0,1]",
                                   "zero", "not used: classifier.0.bias"})
        CHECK(contains(text.out, part));
    CHECK(contains(text.out, "sha256      " + hash));
    CHECK(contains(text.out, "scale       other"));

    fresco::write_file(place.file("bad.pth"), std::string("nothing of the kind"));
    CHECK(place.run({"inspect", "bad.pth"}).code == 1);
    // Control characters in a file's metadata are replaced in errors, too.
    fresco::write_file(place.file("hostile.safetensors"), small_weights({{"input", "a\x1b[2J\u009b1A"}}));
    const Finished hostile = place.run({"inspect", "hostile.safetensors"});
    CHECK(hostile.code == 1);
    CHECK(contains(hostile.err, "a?[2J?1A"));
    CHECK(place.run({"inspect", "none.pth"}).code == 3);
    CHECK(place.run({}).code == 2);
    CHECK(place.run({"get", "vgg16"}).code == 2);
}

TEST_CASE_METHOD(WithPlace, "weights convert writes the convolutions with what they are")
{
    fresco::write_file(place.file("w.safetensors"), bytes);
    REQUIRE(place.run({"convert", "w.safetensors", "out.safetensors"}).code == 0);
    const auto file = fresco::weights::read_weights(place.file("out.safetensors"));
    CHECK(file.contents.tensors.size() == 2);
    CHECK(file.contents.metadata.at("source_sha256") == hash);
    CHECK(contains(file.contents.metadata.at("input"), "RGB"));
    CHECK(file.contents.metadata.at("padding") == "zero");
    CHECK(fresco::weights::to_float32(*file.contents.find("features.0.weight"), "w")[65] == 65.0F / 64);
    CHECK(place.run({"convert", "w.safetensors", "nowhere/out.safetensors"}).code == 1);

    CHECK(place.run({"convert", "w.safetensors", "until.safetensors", "--until", "relu1_1"}).code == 0);
    const auto written = fresco::read_file(place.file("out.safetensors"));
    for (const char* onto : {"out.safetensors", "w.safetensors"})
        CHECK(contains(place.run({"convert", "w.safetensors", onto}).err, "already exists"));
    CHECK(fresco::read_file(place.file("out.safetensors")) == written);
    const Finished beyond = place.run({"convert", "w.safetensors", "beyond.safetensors", "--until", "relu4_1"});
    CHECK(beyond.code == 1);
    CHECK(contains(beyond.err, "relu1_1 to relu1_1"));
}

TEST_CASE_METHOD(WithPlace, "weights get fetches a file once, checks it and goes on where it was interrupted")
{
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

TEST_CASE_METHOD(WithPlace, "weights get refuses what is not the file")
{
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
    // An existing file with other contents is left alone.
    fresco::write_file(place.file("w.pth"), std::string("mine"));
    const Finished mine = get({"--url", server.url(), "--sha256", hash});
    CHECK(mine.code == 1);
    CHECK(contains(mine.err, "remove it"));
    CHECK(fresco::read_text_file(place.file("w.pth")) == "mine");
    place.environment["PATH"] = "/nowhere";
    fs::remove(place.file("w.pth"));
    CHECK(contains(get({"--url", server.url(), "--sha256", hash}).err, "curl is not installed"));
}

TEST_CASE_METHOD(WithPlace, "weights get ends where a server sends too much, and keeps nothing of it")
{
    const fs::path to = place.file("w.pth");
    const auto fetch = [&](const Server& server, std::size_t most_bytes) {
        return fresco::weights::download({server.url(), hash, to, most_bytes});
    };
    for (const char* says : {"says=700000000", "says=0"})
    {
        const Server server(place, bytes, {says});
        CHECK_THROWS_WITH(fetch(server, 5000), Catch::Contains(server.url()) && Catch::Contains("sends more than 5000 bytes"));
        CHECK_FALSE((fs::exists(to) || fs::exists(to.string() + ".fresco-part")));
    }
    const Server server(place, bytes, {"says=0"});
    CHECK(fetch(server, bytes.size() + 1));
    CHECK(fresco::read_file(to) == bytes);
}

TEST_CASE_METHOD(WithPlace, "weights get expects the whole SHA-256, and no http behind https")
{
    // In place of curl, notes what it is asked to do.
    fs::create_directories(place.file("programs"));
    const fs::path curl = place.file("programs/curl");
    fresco::write_file(curl, std::string("#!/bin/sh\necho \"$@\" > " + place.file("asked").string() + "\nexit 7\n"));
    fs::permissions(curl, fs::perms::owner_all);
    place.environment["PATH"] = place.file("programs");
    const auto asked = [&](const std::string& url)
    {
        CHECK(place.run({"get", "vgg19", "--to", "w.pth", "--url", url}).code == 1);
        return fresco::read_text_file(place.file("asked"));
    };
    CHECK(contains(asked("https://127.0.0.1/w.pth"), "--proto-redir =https "));
    CHECK(contains(asked("http://127.0.0.1/w.pth"), "--proto-redir =http,https "));
    CHECK(contains(place.run({"get", "--help"}).out, "dcbb9e9dad569fff7a846263a77324fc34978fea2bfb039c012d710e1776ae44"));
}

TEST_CASE_METHOD(WithPlace, "the words of a command line are offered as fresco asks for them")
{
    const auto offered = [&](std::vector<std::string> words)
    {
        words.insert(words.begin(), "internal-complete");
        return place.run(words).out;
    };
    CHECK(offered({""}) == "convert\nget\ninspect\n");
    CHECK(offered({"get", ""}) == "vgg19\n");
    CHECK(offered({"convert", "--u"}) == "--until\n");
    CHECK(offered({"inspect", ""}) == ":files\n");
}
