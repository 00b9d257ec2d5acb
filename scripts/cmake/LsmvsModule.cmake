# One static library a folder. Includes read "lsmvs/<module>/<file>.h" everywhere: the build tree holds
# include/lsmvs/<module> as a link to the folder, and an installation holds the same paths.

add_library(lsmvs_options INTERFACE)
target_compile_features(lsmvs_options INTERFACE cxx_std_20)
target_compile_options(
  lsmvs_options
  INTERFACE $<BUILD_INTERFACE:-Wall;-Wextra;-Wshadow;-Wconversion;-Wno-sign-conversion;-Wno-psabi>
            # GCC 12 sees overlapping copies in `"a" + std::string` that are not there (its bug 105651).
            $<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>>
            # The same arithmetic in every build: no contraction to FMA behind the author's back.
            $<BUILD_INTERFACE:-ffp-contract=off>)
if(LSMVS_SANITIZE)
  target_compile_options(lsmvs_options INTERFACE $<BUILD_INTERFACE:-fsanitize=${LSMVS_SANITIZE};-fno-omit-frame-pointer;-fno-sanitize-recover=all>)
  target_link_options(lsmvs_options INTERFACE $<BUILD_INTERFACE:-fsanitize=${LSMVS_SANITIZE}>)
  target_compile_definitions(lsmvs_options INTERFACE $<BUILD_INTERFACE:LSMVS_SANITIZED>)
endif()
install(TARGETS lsmvs_options EXPORT lsmvsTargets)

set(LSMVS_INCLUDE_DIR ${CMAKE_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${LSMVS_INCLUDE_DIR}/lsmvs)

# lsmvs_add_module(<name> SOURCES <files> [USES <modules or public packages>] [LINKS <private packages>])
# makes the library lsmvs_<name>, alias lsmvs::<name>, from the current folder.
function(lsmvs_add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES;LINKS" ${ARGN})
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${LSMVS_INCLUDE_DIR}/lsmvs/${name} SYMBOLIC)
  add_library(lsmvs_${name} STATIC ${ARG_SOURCES})
  add_library(lsmvs::${name} ALIAS lsmvs_${name})
  set_target_properties(lsmvs_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(
    lsmvs_${name} PUBLIC $<BUILD_INTERFACE:${LSMVS_INCLUDE_DIR}> $<INSTALL_INTERFACE:include>)
  target_link_libraries(lsmvs_${name} PUBLIC lsmvs_options ${ARG_USES} PRIVATE ${ARG_LINKS})
  install(TARGETS lsmvs_${name} EXPORT lsmvsTargets ARCHIVE DESTINATION lib)
  # The public face of a module: the headers on its doorstep. Sub-folders stay inside.
  file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.h)
  install(FILES ${headers} DESTINATION include/lsmvs/${name})
endfunction()

# lsmvs_add_test(<name> SOURCES <files> USES <libraries> [TIMEOUT <s>] [SHARING_SUITES <suites>]): a
# GoogleTest program whose cases become tests of ctest; a sharing suite is one test.
function(lsmvs_add_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;USES;SHARING_SUITES" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE lsmvs_test_support ${ARG_USES} GTest::gmock GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  # A suite whose tests share what is costly to compute runs in one process.
  set(alone "*")
  foreach(suite IN LISTS ARG_SHARING_SUITES)
    add_test(NAME ${name}.${suite} COMMAND ${name} --gtest_filter=${suite}.*)
    set_tests_properties(${name}.${suite} PROPERTIES TIMEOUT 900)
    if(alone STREQUAL "*")
      set(alone "*-${suite}.*")
    else()
      string(APPEND alone ":${suite}.*")
    endif()
  endforeach()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60
                       TEST_FILTER "${alone}" PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()
