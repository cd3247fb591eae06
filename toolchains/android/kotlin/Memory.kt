// Memory that C sees, and what keeps it there: what the generated classes stand on.
//
// A buffer of Java is kept while an object that points into it is: a struct keeps what its pointers name, and a call keeps its
// arguments. What was closed throws, also where a struct still names it.
package org.sandglass

import java.io.Closeable
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** The library refused; the message is its sentence: what is wrong, where, and what to do. */
class SandglassException(val status: Int, sentence: String?) : RuntimeException(sentence)

/** What a pointer leads to: a buffer, a struct, a handle. */
abstract class Memory { abstract val address: Long }

private fun direct(bytes: Int) = ByteBuffer.allocateDirect(bytes).order(ByteOrder.nativeOrder())

/** Bytes of the app for C to read or write: the whole of a direct buffer. */
class Buffer(val bytes: ByteBuffer) : Memory() {
  constructor(size: Int) : this(direct(size))
  init { require(bytes.isDirect && bytes.order() == ByteOrder.nativeOrder()) { "the buffer is not direct, or not in native order" } }
  override val address = Native.address(bytes)
}

/** Structs that lie together. */
class Span(internal val b: ByteBuffer) : Memory() {
  constructor(size: Int) : this(direct(size))
  private val start = Buffer(b).address
  private val places = ArrayList<Int>()
  private val named = ArrayList<Memory>()
  override val address: Long
    get() {
      for (i in places.indices) b.putLong(places[i], named[i].address)
      return start
    }
  internal fun kept(at: Int) = named.getOrNull(places.indexOf(at))
  internal fun keep(at: Int, of: Memory?) {
    b.putLong(at, of(of))
    val i = places.indexOf(at)
    if (i >= 0) { places.removeAt(i); named.removeAt(i) }
    if (of != null) { places.add(at); named.add(of) }
  }
}

/** A struct at a place of a span. */
abstract class Struct(val span: Span, val at: Int) : Memory() { override val address get() = span.address + at }

/** A fixed array of floats, in a struct or by itself. */
class Floats(private val span: Span, private val at: Int, val count: Int) : Memory() {
  constructor(vararg of: Float) : this(Span(4 * of.size), 0, of.size) { set(*of) }
  override val address get() = span.address + at
  operator fun get(i: Int) = span.b.getFloat(element(at, i, count, 4))
  operator fun set(i: Int, to: Float) { span.b.putFloat(element(at, i, count, 4), to) }
  fun set(vararg to: Float) = to.forEachIndexed { i, one -> this[i] = one }
}

/** An array of pointers, to structs or handles. */
class Pointers(vararg of: Memory) : Memory() {
  private val span = Span(8 * of.size).also { of.forEachIndexed { i, one -> it.keep(8 * i, one) } }
  override val address get() = span.address
}

/** A handle and the block that it lives in. One belongs to one thread at a time. */
abstract class Owned internal constructor(private val kind: String, made_of: Memory, need: (Memory) -> Unit, create: (Memory, Long, Memory) -> Unit) : Memory(), Closeable {
  private val kept = HashMap<String, Memory?>()
  private var block: Buffer?
  private var handle = 0L

  init {
    val answer = Buffer(8)
    need(answer)
    val bytes = answer.bytes.getLong(0)
    if (bytes > Int.MAX_VALUE - SANDGLASS_BLOCK_ALIGNMENT)
      throw SandglassException(SANDGLASS_ERROR_MEMORY_TOO_SMALL, "$kind: a block of $bytes bytes is larger than a buffer can be: lower the capacities.")
    val whole = direct(bytes.toInt() + SANDGLASS_BLOCK_ALIGNMENT)
    (whole as java.nio.Buffer).position((-Native.address(whole)).toInt() and SANDGLASS_BLOCK_ALIGNMENT - 1)  // ByteBuffer's own is newer than Android 24
    block = Buffer(whole.slice().order(ByteOrder.nativeOrder()))
    create(block!!, bytes, answer)
    handle = answer.bytes.getLong(0)
    keep("desc", made_of)
  }

  override val address get() = if (handle != 0L) handle else throw IllegalStateException("this $kind is closed")
  /** What the library told the address of, such as the chunks of a mesh: bytes of this block, valid until the next call. */
  fun memory(address: Long, size: Int): ByteBuffer {
    of(this)
    if (size == 0) return direct(0)
    val begin = address - block!!.address
    require(size > 0 && begin >= 0 && begin + size <= block!!.bytes.capacity()) { "these bytes are not of this $kind" }
    val all = block!!.bytes.duplicate()
    (all as java.nio.Buffer).limit((begin + size).toInt()).position(begin.toInt())
    return all.slice().order(ByteOrder.nativeOrder())
  }
  internal fun keep(by: String, of: Memory?) { kept[by] = of }
  protected open fun release() {}
  override fun close() {
    if (handle != 0L) release()
    handle = 0L
    block = null
  }
}

internal fun of(memory: Memory?) = memory?.address ?: 0L
internal fun of(floats: Floats?, count: Int): Long {
  require(floats == null || floats.count == count) { "${floats!!.count} floats where $count are taken" }
  return of(floats)
}
internal fun element(at: Int, i: Int, count: Int, size: Int) = if (i in 0 until count) at + i * size else throw IndexOutOfBoundsException("$i is not below $count")
