# Writes a source file with the page's sources and three.js as string literals.
#
#   cmake -D OUT=assets.cc -D WEB=apps/report/web -D THREE=/usr/share/javascript/three
#     -P embed.cmake
include(${CMAKE_CURRENT_LIST_DIR}/modules.cmake)

function(embed name path)
  file(READ ${path} content)
  embed_text(${name} "${content}")
endfunction()

function(embed_text name content)
  # Compilers limit the length of one literal but join adjacent ones.
  string(LENGTH "${content}" length)
  set(literal "")
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${content}" ${at} 15000 piece)
    string(APPEND literal "\n    R\"kgweb(${piece})kgweb\"")
    math(EXPR at "${at} + 15000")
  endwhile()
  file(APPEND ${OUT}.part "const char* const ${name} =${literal};\n")
endfunction()

file(WRITE ${OUT}.part "// Made by apps/report/embed.cmake.
#include \"apps/report/page.h\"

namespace kinegraph::assets {

")
embed(kPageHtml ${WEB}/page.html)
embed(kPageCss ${WEB}/page.css)
join_modules(${WEB} page_js)
embed_text(kPageJs "${page_js}")
embed(kThreeJs ${THREE}/three.min.js)
embed(kOrbitControlsJs ${THREE}/examples/js/controls/OrbitControls.js)
file(APPEND ${OUT}.part "
}  // namespace kinegraph::assets
")
file(RENAME ${OUT}.part ${OUT})
