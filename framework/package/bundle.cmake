# Run by CPack between installing and packing. Puts into the archive the libraries that program and plugins load, except glibc's and a
# GPU driver's, and the licenses and versions of the Debian packages that they come from.
if(NOT CPACK_GENERATOR STREQUAL "TZST")
    return()
endif()
set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
set(bundled ${root}/lib/fresco/bundled)
set(documents ${root}/share/doc)

file(GLOB plugins ${root}/lib/fresco/*.so)
file(GLOB programs ${root}/bin/fresco*)
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${programs} MODULES ${plugins} RESOLVED_DEPENDENCIES_VAR libraries
     PRE_EXCLUDE_REGEXES "^libcuda\\.so" "^libnvidia-" POST_EXCLUDE_REGEXES "^${root}/")

# dpkg knows a file by its path before or after Debian moved /lib to /usr/lib.
set(paths)
foreach(library IN LISTS libraries)
    file(REAL_PATH ${library} file)
    string(REGEX REPLACE "^/usr" "" old_path ${file})
    list(APPEND paths ${file} ${old_path})
endforeach()
execute_process(COMMAND dpkg-query --search ${paths} OUTPUT_VARIABLE owners ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
string(REPLACE "\n" ";" owners "${owners}")
foreach(line IN LISTS owners)
    if(line MATCHES "^([^:, ]+)[^ ]*: (/usr)?(.*)$")
        set("package_of_${CMAKE_MATCH_3}" ${CMAKE_MATCH_1})
    endif()
endforeach()

file(MAKE_DIRECTORY ${bundled})
set(packages)
foreach(library IN LISTS libraries)
    file(REAL_PATH ${library} file)
    string(REGEX REPLACE "^/usr" "" path ${file})
    set(package ${package_of_${path}})
    if(NOT package)
        message(FATAL_ERROR "${library} belongs to no Debian package, so its license is unknown: build with the libraries of Debian")
    elseif(NOT package STREQUAL "libc6")
        get_filename_component(name ${library} NAME)
        file(COPY_FILE ${file} ${bundled}/${name})
        list(APPEND packages ${package})
    endif()
endforeach()

list(REMOVE_DUPLICATES packages)
list(SORT packages)
foreach(package IN LISTS packages)
    file(MAKE_DIRECTORY ${documents}/${package})
    file(COPY_FILE /usr/share/doc/${package}/copyright ${documents}/${package}/copyright)
endforeach()
# The licenses that those texts name by their place.
file(COPY /usr/share/common-licenses DESTINATION ${root}/share)
execute_process(COMMAND dpkg-query --show "--showformat=\${Package} \${Version} \${source:Package} \${source:Version}\\n" ${packages}
                OUTPUT_FILE ${documents}/fresco/bundled.txt COMMAND_ERROR_IS_FATAL ANY)
