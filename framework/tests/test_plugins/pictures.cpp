// Shows text files with a number as pictures of that number. 13 crashes it, 14 is broken, 15 takes as long as a file "open" lies
// in the working folder.
#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>
#include <fresco/viewer.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

namespace
{

class TextViewer final : public fresco::Viewer
{
  public:
    TextViewer() : Viewer(fresco::RegisteredArtifact<fresco::Files>::type) {}
    std::vector<std::string> extensions() const override { return {".png", ".jpg", ".jpeg"}; }
    void show(const fresco::Artifact& artifact, fresco::PageEntry& entry) const override
    {
        const auto& files = dynamic_cast<const fresco::Files&>(artifact);
        for (const std::string& name : entry.names.empty() ? files.names : entry.names)
            if (name.ends_with(".png"))
                entry.append("pictures",
                             fresco::Value::Map{{"name", name}, {"uri", picture(files.loaded_from / name, entry.longest_px)}});
    }

  private:
    static std::string picture(const std::filesystem::path& file, int longest_px)
    {
        const int value = std::stoi(fresco::read_text_file(file));
        if (value == 13)
            std::raise(SIGSEGV);
        if (value == 14)
            throw fresco::Error(file.string() + ": is cut");
        const std::filesystem::path open = std::filesystem::current_path() / "open";
        if (value == 15)
            fresco::write_file(open, std::string_view());
        while (value == 15 && std::filesystem::exists(open))
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        return "data:," + std::to_string(longest_px) + "px of " + std::to_string(value);
    }
};
FRESCO_COMPONENT("view.test", TextViewer, fresco::Viewer, "Text for pictures")

}  // namespace
