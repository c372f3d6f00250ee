#include "firmware/iiod/xml.h"

namespace powbench::firmware::iiod {
namespace {

// Debian's client warns about a description without a DTD; every attribute used below is declared here.
constexpr std::string_view document_head =
    "<?xml version=\"1.0\" encoding=\"utf-8\"?><!DOCTYPE context [<!ELEMENT context (device | "
    "context-attribute)*>"
    "<!ELEMENT context-attribute EMPTY>"
    "<!ELEMENT device (channel | attribute | debug-attribute | buffer-attribute)*><!ELEMENT channel "
    "(scan-element?, attribute*)>"
    "<!ELEMENT attribute EMPTY><!ELEMENT scan-element EMPTY><!ELEMENT debug-attribute EMPTY><!ELEMENT "
    "buffer-attribute EMPTY>"
    "<!ATTLIST context name CDATA #REQUIRED version-major CDATA #REQUIRED version-minor CDATA #REQUIRED "
    "version-git CDATA #REQUIRED description CDATA #IMPLIED>"
    "<!ATTLIST context-attribute name CDATA #REQUIRED value CDATA #REQUIRED>"
    "<!ATTLIST device id CDATA #REQUIRED name CDATA #IMPLIED label CDATA #IMPLIED>"
    "<!ATTLIST channel id CDATA #REQUIRED type (input|output) #REQUIRED name CDATA #IMPLIED>"
    "<!ATTLIST scan-element index CDATA #REQUIRED format CDATA #REQUIRED scale CDATA #IMPLIED>"
    "<!ATTLIST attribute name CDATA #REQUIRED filename CDATA #IMPLIED><!ATTLIST debug-attribute name CDATA "
    "#REQUIRED>"
    "<!ATTLIST buffer-attribute name CDATA #REQUIRED>]>";

void put_escaped(CharSink& out, std::string_view s) {
  for (const char c : s) {
    switch (c) {
      case '&':
        out.put("&amp;");
        break;
      case '<':
        out.put("&lt;");
        break;
      case '>':
        out.put("&gt;");
        break;
      case '"':
        out.put("&quot;");
        break;
      default:
        out.put(c);
    }
  }
}

void put_attribute(CharSink& out, std::string_view name, std::string_view value) {
  out.put(' ');
  out.put(name);
  out.put("=\"");
  put_escaped(out, value);
  out.put('"');
}

void put_names(CharSink& out, std::string_view element, std::span<const Attribute> attributes) {
  for (const Attribute& a : attributes) {
    out.put('<');
    out.put(element);
    put_attribute(out, "name", a.name);
    out.put(" />");
  }
}

void put_channel(CharSink& out, const Channel& channel) {
  out.put("<channel");
  put_attribute(out, "id", channel.id);
  put_attribute(out, "type", channel.output ? "output" : "input");
  out.put('>');
  if (channel.scan_index >= 0) {
    TextOf<24> index;
    index.put_int(channel.scan_index);
    out.put("<scan-element");
    put_attribute(out, "index", index.view());
    put_attribute(out, "format", channel.bits == 64 ? "le:S64/64>>0" : "le:S16/16>>0");
    out.put(" />");
  }
  put_names(out, "attribute", channel.attributes);
  out.put("</channel>");
}

void put_device(CharSink& out, const Device& device) {
  out.put("<device");
  put_attribute(out, "id", device.id);
  put_attribute(out, "name", device.name);
  if (!device.label.empty()) put_attribute(out, "label", device.label);
  out.put('>');
  for (const Channel& channel : device.channels) put_channel(out, channel);
  put_names(out, "attribute", device.attributes);
  put_names(out, "buffer-attribute", device.buffer_attributes);
  out.put("</device>");
}

}  // namespace

void write_xml(const Context& context, CharSink& out) {
  out.put(document_head);
  out.put("<context");
  put_attribute(out, "name", "network");
  put_attribute(out, "version-major", "0");
  put_attribute(out, "version-minor", "24");
  put_attribute(out, "version-git", "v0.24  ");
  put_attribute(out, "description", context.description);
  out.put('>');
  for (const ContextAttribute& a : context.attributes) {
    out.put("<context-attribute");
    put_attribute(out, "name", a.name);
    put_attribute(out, "value", a.value);
    out.put(" />");
  }
  for (const Device* device : context.devices) put_device(out, *device);
  out.put("</context>");
}

}  // namespace powbench::firmware::iiod
