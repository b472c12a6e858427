#ifndef FRESCO_ABI_H
#define FRESCO_ABI_H

/* The C handshake between host and plugin. Nothing of C++ crosses before the host has compared every field of fresco_plugin_info.
 *
 * History of FRESCO_ABI:
 *   1  first
 *   2  Files::loaded_from, ImageIo::check, LossTerm::network, Pixels::steep
 *   3  RunContext::reads_folder with a pattern, Cost::height_squares
 *   4  Slot that is optional though it has a default; Part::fine_among_selected
 *   5  Part::fine_among_selected gives numbers; TextureRepresentation::move_to, OptimizerRule::runs_on;
 *      UvMaps::write_map with uv_bits
 *   6  Texture::atlas, UvMaps::atlas, ImageIo::read_with_alpha
 *   7  Stage::memory_mb and chooses_device in place of Cost; Viewer; Parameter with an OptionDeclaration, virtual
 *      Artifact::save and write_exchange, ports with an ArtifactType; OptionDeclaration::extensions;
 *      ArtifactFolder::references, Mesh::saved_in, Mesh::texture_px, Mesh::offset_m, Frames::offset_m, MeshReadReport::positions,
 *      UvMaps::texture_px and uv_bits; outputs that may be left out, or name their parts; OptionDeclaration::rule and formats;
 *      FileReader::formats, FileOrigin; RunContext::origin; Part::fine_count; constructors of SlotBase and Value in the library;
 *      OptionDeclaration::of_pipeline and chosen_by, Component::marks, InputPath; one parse_ply, parse_obj and read_mesh;
 *      without AutoRule
 */
#include <stddef.h>
#include <stdint.h>

#define FRESCO_MAGIC 0x46524553u /* "FRES" */
#define FRESCO_ABI 7u

#ifdef __cplusplus
extern "C"
{
#endif

    /* All strings live as long as the library, which is never unloaded. An empty string: not used. */
    struct fresco_plugin_info
    {
        uint32_t magic;
        uint32_t abi;
        const char* compiler;         /* family and major version */
        const char* standard_library; /* with its ABI switch */
        const char* containers;       /* "release" or "debug": what the standard containers were built as */
        const char* torch;            /* version, where the plugin uses it */
        const char* cuda;             /* major version, where its libtorch has it */
    };

    enum fresco_entry_kind
    {
        FRESCO_ENTRY_STAGE = 1,
        FRESCO_ENTRY_COMPONENT = 2,
        FRESCO_ENTRY_LIBRARY = 3 /* type: a library's name, help: its version */
    };

    struct fresco_plugin_entry
    {
        int what;         /* fresco_entry_kind */
        const char* type; /* "mesh.decimate" */
        const char* kind; /* "stage", or the component's contract */
        const char* help;
        void* (*create)(void); /* a new fresco::Configurable, owned by the caller; null for a library */
    };

    /* The two symbols that a plugin exports; fresco_add_plugin adds them. */
    typedef const struct fresco_plugin_info* (*fresco_plugin_info_function)(void);
    typedef const struct fresco_plugin_entry* (*fresco_plugin_entries_function)(size_t* count);

#define FRESCO_INFO_SYMBOL "fresco_plugin_info_1"
#define FRESCO_ENTRIES_SYMBOL "fresco_plugin_entries_1"

#ifdef __cplusplus
}
#endif

#endif
