# find_package(propmap) with propmap_ROOT set to the folder above that of `propmap --include-dir`: the target
# propmap::core, headers alone.
if(NOT TARGET propmap::core)
  add_library(propmap::core INTERFACE IMPORTED)
  get_filename_component(propmap_INCLUDE_DIR "${CMAKE_CURRENT_LIST_DIR}/../../../include" ABSOLUTE)
  set_target_properties(propmap::core PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${propmap_INCLUDE_DIR}"
    INTERFACE_COMPILE_FEATURES cxx_std_20)
  # g++'s note on how vectors are passed concerns only programs whose parts are built for different processors.
  target_compile_options(propmap::core INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi>)
endif()
