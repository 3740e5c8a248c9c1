# A file's bytes as a C++ array: cmake -D INPUT=... -D OUTPUT=... -D NAMESPACE=... -D NAME=... -P
file(READ "${INPUT}" bytes HEX)
string(LENGTH "${bytes}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE "${OUTPUT}" "namespace ${NAMESPACE} {
extern const unsigned char ${NAME}[];
extern const unsigned long long ${NAME}_size;
const unsigned char ${NAME}[] = {
${bytes}};
const unsigned long long ${NAME}_size = ${size};
}  // namespace ${NAMESPACE}
")
