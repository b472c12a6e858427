#include "page.h"

#include <fresco/page/page.h>
#include <page_parts.h>

using namespace fresco;

namespace
{
std::string escaped(std::string_view text)
{
    std::string result;
    for (const char c : text)
        result += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    return result;
}
}  // namespace

std::string room_page(const Value& data, std::string_view title)
{
    const PageScripts& viewer = page::room_scripts();
    std::string page = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1, viewport-fit=cover\">\n"
                       "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
                       "style-src 'unsafe-inline'; img-src data: blob:\">\n<link rel=\"icon\" href=\"data:,\">\n<title>";
    page += escaped(title);
    page += "</title>\n<style>";
    page += viewer.css;
    page += page_css;
    page += "</style></head>\n<body>\n<div id=\"room\"><noscript><p class=\"message\">This page shows a room by JavaScript, "
            "which is switched "
            "off here.</p></noscript></div>\n"
            "<nav><button id=\"walk\">Walk</button><button id=\"orbit\">Orbit</button><button id=\"light\" "
            "hidden>Light</button><button id=\"vr\" hidden>Enter "
            "VR</button></nav>\n"
            "<script type=\"application/json\" id=\"data\">";
    page += script_json(data);
    page += "</script>\n<script>";
    page += viewer.library;
    page += "</script>\n<script>\"use strict\";\n";
    page += viewer.js;
    page += page_js;
    page += "</script>\n</body></html>\n";
    return page;
}
