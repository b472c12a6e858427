// A plugin with a type of artifact of its own, which programs exchange in two forms.
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>

namespace
{

struct Note final : fresco::Artifact
{
    static constexpr std::string_view artifact_name = "test_note";
    static constexpr int artifact_version = 2;

    std::string text;

    void save(const fresco::ArtifactFolder& folder) const override { fresco::write_file(folder.path / "note.txt", text); }
    static std::shared_ptr<Note> load(const fresco::ArtifactFolder& folder)
    {
        auto note = std::make_shared<Note>();
        note->text = fresco::read_text_file(folder.path / "note.txt");
        return note;
    }

    static std::vector<fresco::ExchangeForm> exchange_forms()
    {
        const fresco::ExchangeForm json{
            .as = "json", .files = {"note.json"}, .is_folder = false, .taken_in_place = false, .made_in_place = false};
        return {{.as = "folder", .files = {"note.txt"}}, json};
    }
    void write_exchange(const fresco::Exchange& to) const override
    {
        fresco::write_file(to.folder.path / "note.json", to_json(fresco::Value(text)));
    }
    static std::shared_ptr<Note> from_exchange(const fresco::Exchange& from)
    {
        if (from.as == "folder")
            return load(from.folder);
        auto note = std::make_shared<Note>();
        const auto file = from.folder.path / "note.json";
        note->text = fresco::parse_json(fresco::read_text_file(file), file.string()).as_string();
        return note;
    }
};

class NoteStage final : public fresco::Stage
{
    fresco::Option<std::string> text{this, "text", "", "The note"};
    fresco::Output<Note> note{this, "note", "The note"};

    void run(fresco::RunContext&) override
    {
        Note made;
        made.text = *text;
        note = std::move(made);
    }
};

}  // namespace

FRESCO_STAGE("test.note", NoteStage, "A note")
