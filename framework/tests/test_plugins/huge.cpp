// A plugin for which a limit on memory leaves no room: it takes 1.5 GB of addresses.
#include <cstddef>

extern char fresco_test_room[std::size_t{3} << 29U];
char fresco_test_room[std::size_t{3} << 29U];
