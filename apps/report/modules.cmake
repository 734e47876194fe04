# The modules of the page's script, each after those that it imports.
set(page_modules data playback scene pictures panels charts summary identity keep page)

# Joins them into one script, because browsers do not load modules for a page
# opened from disk. The modules then share one scope; `import` and `export` are
# removed here and checked by tests/apps/report/modules_test.cc.
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
