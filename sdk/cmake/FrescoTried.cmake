# fresco_tried(NAME VERSION NEXT): where VERSION is NEXT or newer, says that nobody has tried fresco with it.
function(fresco_tried NAME VERSION NEXT)
    if(VERSION AND NOT VERSION VERSION_LESS NEXT)
        message(STATUS "${NAME} ${VERSION} was not tried with fresco: if the build fails, install one before ${NEXT}, such as that of Debian 13")
    endif()
endfunction()
