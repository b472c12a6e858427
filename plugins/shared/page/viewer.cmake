# What draws a room in a page is built in, with three.js where it is: Debian's libjs-three.
foreach(part css js)
    string(TOUPPER ${part} upper)
    file(GLOB viewer_files CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/viewer/*.${part})
    fresco_read_texts(FRESCO_VIEWER_${upper} ${viewer_files})
endforeach()
find_path(FRESCO_THREE_FOLDER NAMES three.min.js examples/js/controls/OrbitControls.js
          PATHS /usr/share/javascript/three /usr/share/nodejs/three/build NO_CMAKE_FIND_ROOT_PATH)
set(FRESCO_THREE_JS "")
if(FRESCO_THREE_FOLDER AND EXISTS ${FRESCO_THREE_FOLDER}/examples/js/controls/OrbitControls.js)
    fresco_read_texts(FRESCO_THREE_JS ${CMAKE_CURRENT_LIST_DIR}/viewer/three_license.txt ${FRESCO_THREE_FOLDER}/three.min.js
                      ${FRESCO_THREE_FOLDER}/examples/js/controls/OrbitControls.js)
else()
    message(STATUS "three.js was not found: export.page is left out, and the room in report.html cannot be walked through")
endif()
set(room_viewer ${CMAKE_CURRENT_BINARY_DIR}/room_viewer.cpp)
configure_file(${CMAKE_CURRENT_LIST_DIR}/src/room_viewer.cpp.in ${room_viewer} @ONLY)
# Clang reminds of the 65536 characters that a compiler must be able to read.
set_source_files_properties(${room_viewer} PROPERTIES COMPILE_OPTIONS $<$<CXX_COMPILER_ID:Clang>:-Wno-overlength-strings>)
set_property(SOURCE ${room_viewer} PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
target_sources(fresco_page PRIVATE ${room_viewer})
