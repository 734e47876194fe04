# The modules of the page's script, each after those that it uses: values and
# events below, drawing above them, the page on top.
set(page_modules data playback scene pictures panels charts summary identity keep page)

# Joins them into one script: a browser loads no module from a page on disk. Their
# names share one scope then, so what `import` and `export` say is checked by a
# test (tests/apps/report/modules_test.cc), and dropped here.
function(join_modules folder result)
  set(script "'use strict';\n(function () {\n")
  foreach(module ${page_modules})
    file(READ ${folder}/${module}.js content)
    string(REGEX REPLACE "\nimport {[^}]*} from '[^']*';" "" content "\n${content}")
    string(REPLACE "\nexport " "\n" content "${content}")
    string(APPEND script "${content}")
  endforeach()
  set(${result} "${script}})();\n" PARENT_SCOPE)
endfunction()
