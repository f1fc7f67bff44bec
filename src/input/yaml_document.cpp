#include "input/yaml_document.hpp"

#include <algorithm>

#include "trefoil/input_error.hpp"

namespace trefoil {

YamlDocument::YamlDocument(const std::string &path, const std::string &text) : path_(path) {
  yaml_parser_initialize(&parser_);
  yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char *>(text.data()),
                               text.size());
  if (!yaml_parser_load(&parser_, &document_)) {
    const std::string problem = problem_of_parser(text);
    yaml_parser_delete(&parser_);
    throw InputError(problem);
  }
}

YamlDocument::~YamlDocument() {
  yaml_document_delete(&document_);
  yaml_parser_delete(&parser_);
}

bool YamlDocument::has_another() {
  yaml_document_t next;
  if (!yaml_parser_load(&parser_, &next)) return true;
  const bool found = yaml_document_get_root_node(&next) != nullptr;
  yaml_document_delete(&next);
  return found;
}

void YamlDocument::refuse(const yaml_node_t *where, const std::string &why) const {
  throw InputError(place(where->start_mark.line) + why);
}

std::string YamlDocument::place(std::size_t line) const {
  return "scene file '" + path_ + "', line " + std::to_string(line + 1) + ": ";
}

std::string YamlDocument::problem_of_parser(const std::string &text) const {
  const std::size_t line = parser_.problem_mark.line;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line && begin != text.npos; ++i) {
    begin = text.find('\n', begin);
    if (begin != text.npos) ++begin;
  }
  const bool has_tab = begin != text.npos &&
                       text.substr(begin, text.find('\n', begin) - begin).find('\t') != text.npos;
  return place(line) + (parser_.problem ? parser_.problem : "it is no YAML") +
         (has_tab ? "; a tabulator stands there, and YAML is indented by blanks"
                  : "; check indentation, brackets and quotes");
}

std::string text_of(const yaml_node_t *scalar) {
  std::string text{reinterpret_cast<const char *>(scalar->data.scalar.value),
                   scalar->data.scalar.length};
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  return text;
}

bool is_null(const yaml_node_t *node) {
  if (node->type != YAML_SCALAR_NODE || node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE) {
    return false;
  }
  const std::string text = text_of(node);
  return text.empty() || text == "~" || text == "null";
}

}  // namespace trefoil
