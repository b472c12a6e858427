#include "class_names.h"

#include <array>

std::optional<std::string_view> nyu40_name(std::int64_t id)
{
    constexpr std::array<std::string_view, 40> names{"wall",       "floor",          "cabinet",        "bed",
                                                     "chair",      "sofa",           "table",          "door",
                                                     "window",     "bookshelf",      "picture",        "counter",
                                                     "blinds",     "desk",           "shelves",        "curtain",
                                                     "dresser",    "pillow",         "mirror",         "floor mat",
                                                     "clothes",    "ceiling",        "books",          "refrigerator",
                                                     "television", "paper",          "towel",          "shower curtain",
                                                     "box",        "whiteboard",     "person",         "night stand",
                                                     "toilet",     "sink",           "lamp",           "bathtub",
                                                     "bag",        "otherstructure", "otherfurniture", "otherprop"};
    if (id < 1 || id > static_cast<std::int64_t>(names.size()))
        return std::nullopt;
    return names[static_cast<std::size_t>(id - 1)];
}
