// The page of the viewer for browsers with a scene in it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// What a page shows.
struct WebPage {
  std::string title = {};       ///< of the page, and the name of the scene
  std::string scene = {};       ///< its URL; empty where it is in the page
  std::string poster = {};      ///< URL of the picture for the first second; empty: none
  std::string background = {};  ///< "#rrggbb"
  bool turntable = false;       ///< turns slowly from the start
  std::string address = {};     ///< where the page will lie, for link previews; empty: not known
};

/// A text as HTML has it in attributes and between tags.
std::string html_escaped(const std::string& text);

/// Bytes as a URL that holds them, or as the text of a <script> (without its "data:…").
std::string base64(std::span<const std::byte> bytes);

/// The page made from the viewer's own (tools/web/build). `file` is its name, for errors: it fails
/// where that has not the places for a scene. `packed`: the bytes of a scene file that lie in the
/// page, or none.
Expected<std::string> page_with(const std::string& file, const std::string& page,
                                const WebPage& shown, std::span<const std::byte> packed);

/// Folder with the viewer for browsers, page.html and page/: what FLUXGS_WEB names, or that of this
/// checkout or package. Fails, and says how to make it, where it is not there.
Expected<std::string> web_viewer_folder();

}  // namespace fluxgs::cli
